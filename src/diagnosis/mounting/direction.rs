//! Directions of gravity, each with the torque signs that fit best, and the search over the sphere.

use super::form::Form;
use crate::diagnosis::settings::SETTINGS;
use nalgebra::Vector3;
use rayon::prelude::*;

/// A direction with the signs of the torque columns that fit best.
#[derive(Debug, Clone)]
pub(crate) struct Fitted {
    pub direction: Vector3<f64>,
    pub signs: Vec<f64>,
    /// Sum of squares left.
    pub rest: f64,
}

impl Fitted {
    pub(crate) fn at(form: &Form, direction: Vector3<f64>) -> Self {
        let (rest, signs) = form.signed(direction);
        Self { direction, signs, rest }
    }

    /// The declared direction, out of level by as much as feet and tables are, and the columns as they are.
    pub(crate) fn near(form: &Form, declared: Vector3<f64>) -> Self {
        let plain = vec![1.0; form.joints];
        let start = Self {
            direction: declared,
            rest: form.rest(declared, &plain),
            signs: plain,
        };
        start.within(form, |u| u.angle(&declared) < SETTINGS.mounting.other_mounting)
    }

    pub(crate) fn refined(self, form: &Form) -> Self {
        let there = self.within(form, |_| true);
        Self::at(form, there.direction)
    }

    /// The direction nearest to the declared one among those that fit like this one.
    pub(crate) fn toward(mut self, form: &Form, declared: Vector3<f64>) -> Self {
        let most = self.rest * (SETTINGS.mounting.directions_alike / form.samples as f64).exp();
        let mut step = 0.25;
        while step > 2e-5 {
            let here = self.direction.angle(&declared);
            let near = around(&self.direction, step).filter(|u| u.angle(&declared) < here);
            let alike = near.map(|u| (form.rest(u, &self.signs), u)).filter(|t| t.0 <= most);
            match alike.min_by(|a, b| a.1.angle(&declared).total_cmp(&b.1.angle(&declared))) {
                Some((rest, direction)) => (self.rest, self.direction) = (rest, direction),
                None => step *= 0.5,
            }
        }
        self
    }

    /// Compass search: steps of the sphere in eight directions, halved when none helps, from half the way between two starting
    /// points down to a thousandth of a degree.
    fn within(mut self, form: &Form, allowed: impl Fn(&Vector3<f64>) -> bool) -> Self {
        let mut step = 0.25;
        while step > 2e-5 {
            let near: Vec<Vector3<f64>> = around(&self.direction, step).filter(&allowed).collect();
            let tried: Vec<(f64, Vector3<f64>)> = near.into_par_iter().map(|u| (form.rest(u, &self.signs), u)).collect();
            match tried.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((rest, direction)) if rest < self.rest => (self.rest, self.direction) = (rest, direction),
                _ => step *= 0.5,
            }
        }
        self
    }
}

/// Eight directions at an angle of `step` to one.
fn around(u: &Vector3<f64>, step: f64) -> impl Iterator<Item = Vector3<f64>> {
    let x = u.cross(&smallest_axis(u)).normalize();
    let (u, y) = (*u, u.cross(&x));
    (0..8).map(move |k| {
        let (s, c) = (k as f64 * std::f64::consts::FRAC_PI_4).sin_cos();
        (u * f64::cos(step) + (x * c + y * s) * f64::sin(step)).normalize()
    })
}

fn smallest_axis(u: &Vector3<f64>) -> Vector3<f64> {
    Vector3::ith(u.iamin(), 1.0)
}

/// Axes and space diagonals, both ways.
pub(crate) fn starts() -> Vec<Vector3<f64>> {
    let ends = [-1.0, 1.0];
    let axes = (0..3).flat_map(|i| ends.map(|s| Vector3::ith(i, s)));
    let diagonals = (0..8).map(|k| Vector3::from_fn(|i, _| ends[k >> i & 1]).normalize());
    axes.chain(diagonals).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_no_direction_is_far_from_a_start() {
        let starts = starts();
        assert_eq!(starts.len(), 14);
        for k in 0..1000 {
            // Fibonacci's spiral covers the sphere evenly.
            let z = 1.0 - 2.0 * (k as f64 + 0.5) / 1000.0;
            let (s, c) = (2.399_963 * k as f64).sin_cos();
            let u = Vector3::new((1.0 - z * z).sqrt() * c, (1.0 - z * z).sqrt() * s, z);
            let nearest = starts.iter().map(|v| v.angle(&u)).fold(f64::INFINITY, f64::min);
            assert!(nearest < 0.8, "{nearest}");
        }
    }
}
