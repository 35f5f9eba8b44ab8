//! Filtering forwards and backwards, so that nothing is delayed.

use super::butterworth::{LowPass, Section};
use crate::dynamics::{LANES, Pack, Real};
use crate::preparation::spectrum::{forward, inverse};
use multiversion::multiversion;

/// How a record goes on beyond its ends while it is filtered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Padding {
    /// `2 x(0) − x(−t)`: value and slope go on.
    Odd,
    /// The record is one period of something that repeats.
    Periodic,
}

/// Zero-phase filtering: forwards, then backwards (gain `|H|²`). With odd padding the record is continued by `pad` samples on
/// both sides, cut to its length less one, and the filter starts in the steady state of the first of them (Gustafsson's problem
/// solved as in common practice). What repeats has no ends: its Fourier lines are weighted by `|H|²`, which is what endless
/// padding comes to.
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
    in_groups(&filter.sections, &mut y, TOGETHER);
    y[pad..pad + x.len()].to_vec()
}

/// [`zero_phase`] of several records of the same length, to the last bit. Eight go through the recursion side by side: each of
/// its steps waits for the one before, so eight take hardly longer than one.
///
/// # Panics
/// When the lengths differ.
pub fn zero_phase_all(filter: &LowPass, records: &[&[f64]], padding: Padding, pad: usize) -> Vec<Vec<f64>> {
    let samples = records.first().map_or(0, |x| x.len());
    zero_phase_rows(filter, records, padding, pad, 0..samples)
}

/// The samples `rows` of [`zero_phase_all`].
///
/// # Panics
/// When the lengths differ.
pub(crate) fn zero_phase_rows(
    filter: &LowPass,
    records: &[&[f64]],
    padding: Padding,
    pad: usize,
    rows: impl Iterator<Item = usize> + Clone,
) -> Vec<Vec<f64>> {
    let samples = records.first().map_or(0, |x| x.len());
    let alone = |x: &[f64]| {
        let y = zero_phase(filter, x, padding, pad);
        rows.clone().map(|s| y[s]).collect()
    };
    if samples < 2 || padding == Padding::Periodic {
        return records.iter().map(|x| alone(x)).collect();
    }
    let pad = pad.min(samples - 1);
    let group = |some: &[&[f64]]| match some {
        [one] => vec![alone(one)],
        _ => side_by_side(filter, some, pad, rows.clone()),
    };
    records.chunks(LANES).flat_map(group).collect()
}

/// Up to eight records of the same length; lanes without a record repeat the last one.
fn side_by_side(filter: &LowPass, records: &[&[f64]], pad: usize, rows: impl Iterator<Item = usize> + Clone) -> Vec<Vec<f64>> {
    let (samples, last) = (records[0].len(), records.len() - 1);
    assert!(records.iter().all(|x| x.len() == samples), "records of one length");
    let lanes: [&[f64]; LANES] = std::array::from_fn(|lane| &records[lane.min(last)][..samples]);
    let mut y = vec![Pack::zero(); samples + 2 * pad];
    interleave(&lanes, &mut y[pad..pad + samples]);
    let two = Pack::splat(2.0);
    for i in 1..=pad {
        y[pad - i] = two * y[pad] - y[pad + i];
        let end = pad + samples - 1;
        y[end + i] = two * y[end] - y[end - i];
    }
    both_ways(&filter.sections, &mut y);
    let mut filtered = vec![Vec::with_capacity(rows.size_hint().0); records.len()];
    for s in rows {
        let pack = y[pad + s].0;
        filtered.iter_mut().zip(pack).for_each(|(own, v)| own.push(v));
    }
    filtered
}

/// Sample s of every record into pack s, by squares of eight samples of eight records: what is read and written lies together.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx512bw", "x86_64+avx2"))]
fn interleave(records: &[&[f64]; LANES], packs: &mut [Pack]) {
    let whole = packs.len() / LANES * LANES;
    let (squares, rest) = packs.split_at_mut(whole);
    for (k, square) in squares.chunks_exact_mut(LANES).enumerate() {
        let own: [Pack; LANES] = records.map(|x| Pack::load(&x[k * LANES..]));
        for (s, pack) in square.iter_mut().enumerate() {
            *pack = Pack(std::array::from_fn(|lane| own[lane].0[s]));
        }
    }
    for (s, pack) in rest.iter_mut().enumerate() {
        *pack = Pack(records.map(|x| x[whole + s]));
    }
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

/// Sections that run through the record together: each waits for its own last output, so several at once take no longer than one,
/// as long as their states stay in registers. Of packs, the states of two fill them.
const TOGETHER: usize = 4;
const PACKS_TOGETHER: usize = 2;

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx512bw", "x86_64+avx2"))]
fn both_ways(sections: &[Section], x: &mut [Pack]) {
    in_groups(sections, x, PACKS_TOGETHER);
}

/// Forwards through all sections, then backwards.
#[inline(always)]
fn in_groups<R: Real>(sections: &[Section], x: &mut [R], most: usize) {
    let first = x[0];
    for some in sections.chunks(most) {
        group(some, x.iter_mut(), first);
    }
    let last = x[x.len() - 1];
    for some in sections.chunks(most) {
        group(some, x.iter_mut().rev(), last);
    }
}

/// At most four sections, from the steady state of the first sample.
#[inline(always)]
fn group<'a, R: Real + 'a>(sections: &[Section], x: impl Iterator<Item = &'a mut R>, steady: R) {
    match sections {
        [a] => together(&[a], x, steady),
        [a, b] => together(&[a, b], x, steady),
        [a, b, c] => together(&[a, b, c], x, steady),
        [a, b, c, d] => together(&[a, b, c, d], x, steady),
        _ => unreachable!("chunks of at most four"),
    }
}

/// Direct form II transposed.
#[inline(always)]
fn together<'a, R: Real + 'a, const K: usize>(sections: &[&Section; K], x: impl Iterator<Item = &'a mut R>, steady: R) {
    // Every section passes a constant unchanged, so all of them see the same steady input.
    let mut states = sections.map(
        |Section {
             b: [_, b1, b2],
             a: [a1, a2],
         }| {
            let s2 = R::splat(b2 - a2) * steady;
            (R::splat(b1 - a1) * steady + s2, s2)
        },
    );
    for v in x {
        for (section, (s1, s2)) in sections.iter().zip(&mut states) {
            let ([b0, b1, b2], [a1, a2]) = (section.b.map(R::splat), section.a.map(R::splat));
            let y = b0 * *v + *s1;
            *s1 = b1 * *v - a1 * y + *s2;
            *s2 = b2 * *v - a2 * y;
            *v = y;
        }
    }
}
