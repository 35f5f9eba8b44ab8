//! Expected evidence held against least squares on rows, its derivative against differences.

use super::*;

fn columns() -> DMatrix<f64> {
    DMatrix::from_fn(40, 7, |r, c| ((3 * r * r + 5 * c * c + 7 * r * c + r) as f64 * 0.37).sin())
}

fn rivals() -> Rivals {
    let side = |columns: Range<usize>, values: &[f64]| Hypothesis {
        columns,
        values: values.to_vec(),
        borders: Vec::new(),
    };
    Rivals {
        finding: side(0..2, &[0.7, -0.2]),
        rival: side(2..3, &[1.3]),
        recorded: None,
        nested: [false; 2],
    }
}

/// By orthogonal projection of the rows themselves.
#[test]
fn prop_evidence_is_the_residual_of_the_rivals_least_squares_fit() {
    let w = columns();
    let gram = w.tr_mul(&w);
    let found = rivals().expected(&gram, 4);
    let residual = |own: &[usize], values: &[f64]| {
        let target: DVector<f64> = own.iter().zip(values).map(|(&i, v)| w.column(i) * *v).sum();
        let free: Vec<usize> = (0..7).filter(|i| !own.contains(i)).collect();
        let basis = w.select_columns(&free).qr().q();
        (&target - &basis * basis.tr_mul(&target)).norm_squared()
    };
    let (a, b) = (residual(&[4, 5], &[0.7, -0.2]), residual(&[6], &[1.3]));
    // Normal equations of a well-conditioned random matrix and a ridge of 1e-12: ten digits are left.
    assert!((found.if_finding - a).abs() < 1e-9 * a && (found.if_rival - b).abs() < 1e-9 * b);
    // A copy of A's contribution among the free columns leaves nothing.
    let mut same = w.clone();
    let copy = same.column(4) * 0.7 - same.column(5) * 0.2;
    same.set_column(0, &copy);
    let none = rivals().expected(&same.tr_mul(&same), 4).if_finding;
    assert!(none < 1e-9 * a, "{none}");
}

#[test]
fn prop_derivative_equals_the_difference() {
    let w = columns();
    let gram = |h: f64| {
        let moved = DMatrix::from_fn(40, 7, |r, c| w[(r, c)] + h * ((r + 11 * c) as f64).cos());
        moved.tr_mul(&moved)
    };
    let pair = rivals();
    let h = 1e-6;
    let (value, slope) = pair.smooth(&gram(0.0), 4, 10.0);
    let difference = (pair.smooth(&gram(h), 4, 10.0).0 - pair.smooth(&gram(-h), 4, 10.0).0) / (2.0 * h);
    let exact = slope.dot(&((gram(h) - gram(-h)) / (2.0 * h)));
    assert!((difference - exact).abs() < 1e-7, "{difference} {exact}");
    // Above the true value by at most ln(2)/(2 p).
    let over = value - pair.true_log_value(&gram(0.0), 4);
    assert!((-1e-12..=2f64.ln() / 20.0).contains(&over), "{over}");
}

/// An offset, and a spring with its rest within two units: columns of ones, of positions, and of ones again.
fn offset_and_spring(reach: Option<f64>) -> Rivals {
    Rivals {
        finding: Hypothesis {
            columns: 0..1,
            values: vec![0.8],
            borders: Vec::new(),
        },
        rival: Hypothesis {
            columns: 1..3,
            values: vec![0.5, 0.9],
            borders: reach.map_or(Vec::new(), |r| vec![vec![1.0, r], vec![1.0, -r]]),
        },
        recorded: None,
        nested: [true, false],
    }
}

fn positions() -> DVector<f64> {
    DVector::from_fn(40, |r, _| 0.3 + (0.41 * r as f64).sin())
}

fn gram_of(q: &DVector<f64>) -> DMatrix<f64> {
    let ones = DVector::from_element(40, 1.0);
    let other = DVector::from_fn(40, |r, _| (0.83 * r as f64).cos());
    let w = DMatrix::from_columns(&[other, ones.clone(), q.clone(), ones]);
    w.tr_mul(&w)
}

/// Springs with their rest at the border are columns of their own: the better of two ordinary fits.
#[test]
fn prop_a_special_case_is_held_against_the_others_border() {
    let (q, reach) = (positions(), 2.0);
    let found = offset_and_spring(Some(reach)).expected(&gram_of(&q), 1);
    let other = DVector::from_fn(40, |r, _| (0.83 * r as f64).cos());
    let residual = |sign: f64| {
        let basis = DMatrix::from_columns(&[other.clone(), q.add_scalar(sign * reach)]).qr().q();
        let target = DVector::from_element(40, 0.8);
        (&target - &basis * basis.tr_mul(&target)).norm_squared()
    };
    let expected = residual(1.0).min(residual(-1.0));
    assert!(expected > 0.1, "{expected}");
    // As above: ten digits.
    assert!(
        (found.if_finding - expected).abs() < 1e-9 * expected,
        "{} {expected}",
        found.if_finding
    );
    assert_eq!(found.least(), found.if_finding.min(found.if_rival));
    // A spring may rest anywhere: then there is no residual, and the other case alone is looked at.
    let anywhere = offset_and_spring(None).expected(&gram_of(&q), 1);
    assert_eq!((anywhere.if_finding, anywhere.least()), (0.0, anywhere.if_rival));
}

#[test]
fn prop_the_border_is_decisive_at_three_deviations() {
    let evidence = |if_finding: f64, if_rival: f64| ExpectedEvidence {
        if_finding,
        if_rival,
        nested: [true, false],
        counts: [true; 2],
    };
    assert!(evidence(9.0, 6.0).decides(6.0));
    assert!(!evidence(8.9, 6.0).decides(6.0) && !evidence(9.0, 5.9).decides(6.0));
    let alike = ExpectedEvidence {
        counts: [false; 2],
        ..evidence(9.0, 9.0)
    };
    assert!(!alike.decides(6.0) && alike.least() == 0.0);
}

#[test]
fn prop_derivative_equals_the_difference_at_a_border() {
    let pair = offset_and_spring(Some(2.0));
    let gram = |h: f64| gram_of(&DVector::from_fn(40, |r, _| positions()[r] + h * (0.29 * r as f64).cos()));
    let h = 1e-6;
    let (_, slope) = pair.smooth(&gram(0.0), 1, 10.0);
    let difference = (pair.smooth(&gram(h), 1, 10.0).0 - pair.smooth(&gram(-h), 1, 10.0).0) / (2.0 * h);
    let exact = slope.dot(&((gram(h) - gram(-h)) / (2.0 * h)));
    assert!((difference - exact).abs() < 1e-7, "{difference} {exact}");
}
