//! Filtering forwards and backwards, so that nothing is delayed.

use super::butterworth::{LowPass, Section};
use crate::preparation::spectrum::{forward, inverse};

/// How a record goes on beyond its ends while it is filtered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Padding {
    /// `2 x(0) − x(−t)`: value and slope go on.
    Odd,
    /// The record is one period of something that repeats.
    Periodic,
}

/// Zero-phase filtering: forwards, then backwards (gain `|H|²`). With odd padding the record is continued by `pad` samples on both sides,
/// cut to its length less one, and the filter starts in the steady state of the first of them (Gustafsson's problem solved as in common
/// practice). What repeats has no ends: its Fourier lines are weighted by `|H|²`, which is what endless padding comes to.
///
/// A record of fewer than two samples is returned as it is.
pub fn zero_phase(filter: &LowPass, x: &[f64], padding: Padding, pad: usize) -> Vec<f64> {
    if x.len() < 2 {
        return x.to_vec();
    }
    if padding == Padding::Periodic {
        return repeating(filter, x);
    }
    let pad = pad.min(x.len() - 1);
    let mut y = padded(x, pad);
    forwards(&filter.sections, &mut y);
    y.reverse();
    forwards(&filter.sections, &mut y);
    y.reverse();
    y[pad..pad + x.len()].to_vec()
}

fn repeating(filter: &LowPass, x: &[f64]) -> Vec<f64> {
    let step = filter.rate_hz / x.len() as f64;
    let mut lines = forward(x);
    lines
        .iter_mut()
        .enumerate()
        .for_each(|(l, v)| *v *= filter.power(l as f64 * step));
    inverse(lines, x.len())
}

fn padded(x: &[f64], pad: usize) -> Vec<f64> {
    let n = x.len();
    let mut y = Vec::with_capacity(n + 2 * pad);
    y.extend((1..=pad).rev().map(|i| 2.0 * x[0] - x[i]));
    y.extend_from_slice(x);
    y.extend((1..=pad).map(|i| 2.0 * x[n - 1] - x[n - 1 - i]));
    y
}

/// Sections that run through the record together: each waits for its own last output, so several at once take no longer than one, as long as their states
/// stay in registers.
const TOGETHER: usize = 4;

/// Direct form II transposed, from the steady state of the first sample.
fn forwards(sections: &[Section], x: &mut [f64]) {
    for some in sections.chunks(TOGETHER) {
        match some {
            [a] => together(&[a], x),
            [a, b] => together(&[a, b], x),
            [a, b, c] => together(&[a, b, c], x),
            [a, b, c, d] => together(&[a, b, c, d], x),
            _ => unreachable!("chunks of at most four"),
        }
    }
}

fn together<const K: usize>(sections: &[&Section; K], x: &mut [f64]) {
    // Every section passes a constant unchanged, so all of them see the same steady input.
    let steady = x[0];
    let mut states = sections.map(
        |Section {
             b: [_, b1, b2],
             a: [a1, a2],
         }| {
            let s2 = (b2 - a2) * steady;
            ((b1 - a1) * steady + s2, s2)
        },
    );
    for v in x.iter_mut() {
        for (section, (s1, s2)) in sections.iter().zip(&mut states) {
            let ([b0, b1, b2], [a1, a2]) = (section.b, section.a);
            let y = b0 * *v + *s1;
            *s1 = b1 * *v - a1 * y + *s2;
            *s2 = b2 * *v - a2 * y;
            *v = y;
        }
    }
}
