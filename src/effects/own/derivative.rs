//! Derivatives of formulas.

use super::tree::{Function, Operation, Tree};

/// `∂tree/∂symbol`, by the rules for sums, products and chains. That of a sign is zero, and that of an absolute value the sign.
///
/// On trees, and not by exmex: its expressions take kilobytes of stack for every level of nesting.
pub fn derivative(tree: &Tree, symbol: usize) -> Tree {
    match tree {
        _ if !tree.has(&|s| s == symbol) => Tree::Number(0.0),
        Tree::Number(_) => Tree::Number(0.0),
        Tree::Symbol(_) => Tree::Number(1.0),
        Tree::Of(f, x) => times(outer(*f, x), derivative(x, symbol)),
        Tree::Pair(o, a, b) => of_pair(*o, [a, b], [derivative(a, symbol), derivative(b, symbol)]),
    }
}

fn times(a: Tree, b: Tree) -> Tree {
    Tree::pair(Operation::Multiply, a, b)
}

fn over(a: Tree, b: Tree) -> Tree {
    Tree::pair(Operation::Divide, a, b)
}

fn power(a: Tree, exponent: f64) -> Tree {
    Tree::pair(Operation::Power, a, Tree::Number(exponent))
}

/// `f'(x)`.
fn outer(function: Function, x: &Tree) -> Tree {
    let of = |f: Function| Tree::of(f, x.clone());
    let one = || Tree::Number(1.0);
    match function {
        Function::Minus => Tree::Number(-1.0),
        Function::Sin => of(Function::Cos),
        Function::Cos => Tree::of(Function::Minus, of(Function::Sin)),
        Function::Tan => over(one(), power(of(Function::Cos), 2.0)),
        Function::Tanh => Tree::pair(Operation::Subtract, one(), power(of(Function::Tanh), 2.0)),
        Function::Exp => of(Function::Exp),
        Function::Ln => over(one(), x.clone()),
        Function::Sqrt => over(Tree::Number(0.5), of(Function::Sqrt)),
        Function::Abs => of(Function::Sign),
        Function::Sign => Tree::Number(0.0),
    }
}

fn of_pair(operation: Operation, [a, b]: [&Tree; 2], [da, db]: [Tree; 2]) -> Tree {
    let (a, b) = (a.clone(), b.clone());
    match operation {
        Operation::Add | Operation::Subtract => Tree::pair(operation, da, db),
        Operation::Multiply => Tree::pair(Operation::Add, times(da, b.clone()), times(a, db)),
        Operation::Divide => {
            let first = over(da, b.clone());
            Tree::pair(Operation::Subtract, first, over(times(a, db), power(b, 2.0)))
        }
        Operation::Power => match b {
            Tree::Number(n) => times(times(b, power(a, n - 1.0)), da),
            // (aᵇ)' = aᵇ (b' ln a + b a'/a).
            _ => {
                let whole = Tree::pair(Operation::Power, a.clone(), b.clone());
                let by_exponent = times(db, Tree::of(Function::Ln, a.clone()));
                times(whole, Tree::pair(Operation::Add, by_exponent, over(times(b, da), a)))
            }
        },
    }
}
