//! A round of local solves: random starts, hops and shakes from what is known, polishing.

use super::control::{Control, Progress};
use crate::excitation::descent::{Descended, Descent, FROM_HOP, FROM_NEAR, POLISH};
use crate::excitation::epoch::{Epoch, Job, Result};
use crate::excitation::moves::{hop, random_numbers, random_start, shake};
use crate::excitation::pool::{Point, is_near};
use crate::excitation::report::StartReport;
use crate::excitation::symmetry::Symmetries;
use crate::excitation::variables::Variables;
use rayon::prelude::*;
use std::sync::Mutex;

/// What the jobs of a search share.
pub(super) struct Run<'a> {
    pub(super) variables: &'a Variables,
    pub(super) symmetries: Symmetries,
    pub(super) descent: Descent<'a>,
    pub(super) seed: u64,
    pub(super) control: &'a dyn Control,
    pub(super) progress: Mutex<Progress>,
}

impl Run<'_> {
    /// A point brought within the limits, with its true value.
    pub(super) fn known(&self, x: Vec<f64>, polished: bool) -> Point {
        let x = self.descent.admissible(x);
        let value = self.descent.true_value(&x);
        let mut progress = self.progress.lock().expect("holders of the lock do not panic");
        progress.best = progress.best.min(value.exp());
        Point { x, value, polished }
    }

    /// Takes in what other searches have found: new niches, and better points of known ones.
    pub(super) fn adopt(&self, champions: &mut Vec<Point>) {
        let others = self.control.others();
        let usable = |p: &Point| p.x.len() == self.variables.len() && p.x.iter().all(|v| v.is_finite());
        // Values are computed afresh: what comes from elsewhere may be of another version of the program.
        let known: Vec<Point> = others
            .into_par_iter()
            .filter(usable)
            .map(|p| self.known(p.x, p.polished))
            .collect();
        for point in known {
            let better = |c: &Point| c.value <= point.value && is_near(self.variables, &c.x, &point.x);
            if !champions.iter().any(better) {
                champions.push(point);
            }
        }
    }

    pub(super) fn round(&self, epoch: &Epoch, round: usize, jobs: usize) -> Vec<(Result, Option<StartReport>)> {
        let results = (0..jobs).into_par_iter().map(|index| self.job(epoch, round, index)).collect();
        self.progress
            .lock()
            .expect("holders of the lock do not panic")
            .rounds_finished = round + 1;
        results
    }

    fn job(&self, epoch: &Epoch, round: usize, index: usize) -> (Result, Option<StartReport>) {
        let mut rng = random_numbers(self.seed, round, index);
        let job = epoch.job(index);
        let points = epoch.pool.points();
        let mut report = None;
        let mut halfway = None;
        let end = match job {
            Job::Start => {
                let start = random_start(self.variables, &mut rng);
                let (end, course) = self.descent.run_from_random(start);
                report = Some(StartReport {
                    initial: course.first().map_or(f64::INFINITY, |p| p.1),
                    reached: end.value.exp(),
                    evaluations: end.evaluations,
                    converged: end.converged,
                    course,
                });
                end
            }
            Job::Hop => {
                let start = hop(self.variables, &self.symmetries, points, &mut rng);
                self.descent.run_while(start, &FROM_HOP, &mut |x, value| {
                    let home = points.iter().any(|p| is_near(self.variables, &p.x, x));
                    halfway = (!home).then_some(value);
                    !home && value <= epoch.promising()
                })
            }
            Job::Shake => self.descent.run(shake(self.variables, points, &mut rng), &FROM_NEAR),
            Job::Polish(at) => self.descent.run(points[at].x.clone(), &POLISH),
        };
        self.tell(&end, report.clone());
        let point = Point {
            x: end.x,
            value: end.value,
            polished: matches!(job, Job::Polish(_)),
        };
        (Result { job, point, halfway }, report)
    }

    fn tell(&self, end: &Descended, start: Option<StartReport>) {
        let mut progress = self.progress.lock().expect("holders of the lock do not panic");
        progress.best = progress.best.min(end.value.exp());
        progress.starts_finished += usize::from(start.is_some());
        progress.start = start;
        progress.evaluations = self.descent.evaluations();
        self.control.progress(&progress);
    }
}
