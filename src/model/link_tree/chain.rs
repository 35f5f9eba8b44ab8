//! Which joints of a tree are the arm.

use super::{ChainEnds, Freedom, LinkTree};
use crate::model::ModelError;
use crate::model::notes::{Notes, some_of};
use crate::model::xml::single;
use std::collections::HashSet;

/// The part of a tree that is the arm.
pub(super) struct Chain {
    pub base: usize,
    /// From base to tip, fixed ones too; the last one moves.
    pub joints: Vec<usize>,
}

impl LinkTree {
    /// # Errors
    /// No such links, no movable joint, several chains and no `tip`, joints that a serial arm cannot have.
    pub(super) fn chain(&self, ends: ChainEnds) -> Result<Chain, ModelError> {
        let named = |what: &str, name: &str| {
            self.link(name).ok_or_else(|| {
                let names: Vec<&str> = self.links.iter().map(|l| l.name.as_str()).collect();
                let hint = format!("use the name of a link in the file: {}", some_of(&names));
                single(&format!("/{what}"), format!("the file has no link `{name}`"), hint)
            })
        };
        let tip = ends.tip.map(|name| named("tip", name)).transpose()?;
        let base = ends.base.map(|name| named("base", name)).transpose()?;
        let base = match base {
            Some(base) => base,
            None => self.root_of(tip)?,
        };
        let tip = match tip {
            Some(tip) => tip,
            None => self.only_end(base)?,
        };
        let mut joints = self.path(base, tip)?;
        // What hangs on the last movable joint by fixed joints is lumped into its link.
        while joints.last().is_some_and(|&j| self.joints[j].freedom == Freedom::Fixed) {
            joints.pop();
        }
        if joints.is_empty() {
            let detail = format!(
                "has no movable joint between the links `{}` and `{}`",
                self.links[base].name, self.links[tip].name
            );
            let hint = "a robot has at least one revolute, continuous or prismatic joint; name the last link of the arm in `tip`";
            return Err(single(self.field, detail, hint));
        }
        self.serial(&joints)?;
        Ok(Chain { base, joints })
    }

    /// Where the tree of `tip` begins, or the only tree with joints.
    fn root_of(&self, tip: Option<usize>) -> Result<usize, ModelError> {
        if let Some(mut link) = tip {
            while let Some(joint) = self.parent[link] {
                link = self.joints[joint].parent;
            }
            return Ok(link);
        }
        let is_root = |l: &usize| self.parent[*l].is_none() && !self.children[*l].is_empty();
        let roots: Vec<usize> = (0..self.links.len()).filter(is_root).collect();
        match roots[..] {
            [] => Err(single(
                self.field,
                "has no joint between two links",
                "check that the file is complete",
            )),
            [root] => Ok(root),
            _ => {
                let names: Vec<&str> = roots.iter().map(|&l| self.links[l].name.as_str()).collect();
                let detail = format!("has {} trees, which begin at {}", roots.len(), some_of(&names));
                Err(single(
                    self.field,
                    detail,
                    "join them by a fixed joint, or name the last link of the arm in `tip`",
                ))
            }
        }
    }

    /// Joints from `base` to `tip`.
    fn path(&self, base: usize, tip: usize) -> Result<Vec<usize>, ModelError> {
        let (mut joints, mut link) = (Vec::new(), tip);
        while link != base {
            let Some(joint) = self.parent[link] else {
                let (base, tip) = (&self.links[base].name, &self.links[tip].name);
                let detail = format!("`{tip}` does not hang on the link `{base}`");
                return Err(single("/tip", detail, "name a link beyond `base`, or another `base`"));
            };
            joints.push(joint);
            link = self.joints[joint].parent;
        }
        joints.reverse();
        Ok(joints)
    }

    /// Links below `base`, each after the one that carries it.
    fn below(&self, base: usize) -> Vec<usize> {
        let (mut order, mut next) = (vec![base], 0);
        while next < order.len() {
            order.extend(self.children[order[next]].iter().map(|&j| self.joints[j].child));
            next += 1;
        }
        order
    }

    /// Joints that a gripper is made of: those that follow another, and those that others follow with no joint of an arm behind
    /// them.
    fn is_of_arm(&self, base: usize) -> (Vec<bool>, Vec<usize>) {
        let followed: HashSet<&str> = self.joints.iter().filter_map(|j| j.mimics.as_deref()).collect();
        let mut of_arm = vec![false; self.joints.len()];
        // Joints of the arm behind every link.
        let mut behind = vec![0; self.links.len()];
        for &link in self.below(base).iter().rev() {
            for &at in &self.children[link] {
                let joint = &self.joints[at];
                let free = joint.is_movable() && joint.mimics.is_none();
                of_arm[at] = free && (behind[joint.child] > 0 || !followed.contains(joint.name.as_str()));
                behind[link] += behind[joint.child] + usize::from(of_arm[at]);
            }
        }
        (of_arm, behind)
    }

    /// The link at the end of the only chain that begins at `base`.
    fn only_end(&self, base: usize) -> Result<usize, ModelError> {
        let (of_arm, behind) = self.is_of_arm(base);
        if behind[base] == 0 {
            let grippers: Vec<&str> = self
                .joints
                .iter()
                .filter(|j| j.is_movable())
                .map(|j| j.name.as_str())
                .collect();
            let detail = match grippers.is_empty() {
                true => "has no movable joint".to_string(),
                false => format!("has only joints that follow each other: {}", some_of(&grippers)),
            };
            let hint = "a robot has at least one revolute, continuous or prismatic joint of its own";
            return Err(single(self.field, detail, hint));
        }
        // As far as one joint carries all that moves, there is one chain.
        let (mut link, mut shared) = (base, 0);
        loop {
            let ways: Vec<usize> = self.children[link]
                .iter()
                .copied()
                .filter(|&j| of_arm[j] || behind[self.joints[j].child] > 0)
                .collect();
            match ways[..] {
                [] => return Ok(link),
                [only] => {
                    link = self.joints[only].child;
                    shared += usize::from(of_arm[only]);
                }
                _ => return Err(self.several(base, link, shared, &of_arm, &behind)),
            }
        }
    }

    fn several(&self, base: usize, fork: usize, shared: usize, of_arm: &[bool], behind: &[usize]) -> ModelError {
        let last = |&link: &usize| behind[link] == 0 && self.parent[link].is_some_and(|j| of_arm[j]);
        let ends: Vec<usize> = self.below(base).into_iter().filter(last).collect();
        let names: Vec<&str> = ends.iter().map(|&l| self.links[l].name.as_str()).collect();
        let fork = &self.links[fork].name;
        let hint = match shared {
            0 => format!("name the one you mean in `tip`; they part at `{fork}`"),
            n => format!(
                "name the one you mean in `tip`; with `{fork}`, where they part, the arm has {n} joints and all beyond is locked"
            ),
        };
        single(
            self.field,
            format!("has {} chains, which end at {}", ends.len(), some_of(&names)),
            hint,
        )
    }

    /// Whether the joints of a chain are those of a serial arm.
    fn serial(&self, chain: &[usize]) -> Result<(), ModelError> {
        for &at in chain {
            let joint = &self.joints[at];
            if let Some(leader) = &joint.mimics {
                let detail = format!("{} follows `{leader}` (mimic) and is on the chain", joint.place());
                let hint = format!(
                    "a serial arm has independent joints: name a link before it in `tip`, such as `{}`",
                    self.links[joint.parent].name
                );
                return Err(single(self.field, detail, hint));
            }
            if let Freedom::Several(kind) = joint.freedom {
                let detail = format!("{} is {kind} and is on the chain", joint.place());
                let hint = format!(
                    "an arm stands on a fixed base and has revolute, continuous and prismatic joints: \
                     make it fixed, or begin behind it with `base`: `{}`",
                    self.links[joint.child].name
                );
                return Err(single(self.field, detail, hint));
            }
        }
        let movable = chain.iter().filter(|&&j| self.joints[j].is_movable()).count();
        if movable > crate::model::INPUT_LIMITS.joints {
            let detail = format!(
                "the chain has {movable} joints, the most accepted is {}",
                crate::model::INPUT_LIMITS.joints
            );
            return Err(single(self.field, detail, "name a link nearer to the base in `tip`"));
        }
        Ok(())
    }

    /// What is locked, in words.
    pub(super) fn locked(&self, chain: &Chain, notes: &mut Notes) {
        let mut on_chain = vec![false; self.joints.len()];
        chain.joints.iter().for_each(|&j| on_chain[j] = true);
        let (of_arm, _) = self.is_of_arm(chain.base);
        for (at, joint) in self.joints.iter().enumerate().filter(|(at, _)| !on_chain[*at]) {
            let why = match (&joint.mimics, joint.freedom) {
                (_, Freedom::Fixed) => continue,
                (_, Freedom::Several(kind)) => format!("is {kind} and not on the chain"),
                (Some(leader), _) => format!("follows `{leader}` (mimic)"),
                (None, _) if of_arm[at] => "is not on the chain".to_string(),
                (None, _) => "moves a gripper".to_string(),
            };
            notes.push(format!(
                "joint `{}` {why}: it is locked at zero, and its links belong to the link that carries them",
                joint.name
            ));
        }
        for &at in &chain.joints {
            let name = &self.joints[at].name;
            let followers = self.joints.iter().filter(|j| j.mimics.as_deref() == Some(name));
            let followers: Vec<&str> = followers.map(|j| j.name.as_str()).collect();
            if !followers.is_empty() {
                notes.push(format!(
                    "joint `{name}` also moves {}, which the model of a serial arm does not: its torque holds with these locked",
                    some_of(&followers)
                ));
            }
        }
    }
}
