//! Trials of the tracing on virtual robots, and the tables of `docs/closing-the-loop.md`.
//!
//! - `trials family COUNT [FIRST] [CODE…]`: the published iiwa 14 with one, two or three hidden effects of any size, judged.
//! - `trials detect [REPEATS] [CODE…]`: the size at which half of the logs have their effect found.
//! - `trials confusion [REPEATS] [CODE…]`: what is found for what was hidden.
//! - `trials nothing COUNT [FIRST]`: logs with nothing in them.
//! - `trials grid [CODE…]`: every effect on three joints at three sizes. `trials pairs [COUNT [FIRST]]`.
//! - `trials together [JOINT [TENTHS]] [CODE…]`: effects on one joint, alone and in pairs, at that size. `trials once …`: the
//!   same on logs without periods.
//! - `trials mountings [SEEDS [FIRST]]`: gravity along the axes and space diagonals. `trials rotors [SEEDS [FIRST]]`: a rotor
//!   inertia on every joint.

#[path = "../../tests/effects/bench/mod.rs"]
mod bench;
mod detect;
mod family;
mod grid;
mod judge;
mod mountings;
mod visible;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let numbers: Vec<u64> = arguments.iter().skip(1).map_while(|a| a.parse().ok()).collect();
    let words: Vec<String> = arguments.iter().skip(1 + numbers.len()).cloned().collect();
    let number = |i: usize, otherwise: u64| numbers.get(i).copied().unwrap_or(otherwise);
    match arguments.first().map(String::as_str) {
        Some("family") => family::family(number(0, 40), number(1, 0), &words),
        Some("detect") => detect::detect(number(0, 4), &words),
        Some("confusion") => detect::confusion(number(0, 3), &words),
        Some("nothing") => grid::nothing(number(0, 200), number(1, 0)),
        Some("grid") => grid::grid(&words),
        Some("together") => grid::together(number(0, 3) as usize, number(1, 15) as f64 / 10.0, &words, grid::periodic),
        Some("once") => grid::together(number(0, 3) as usize, number(1, 30) as f64 / 10.0, &words, grid::single_run),
        Some("pairs") => grid::pairs(number(0, 20), number(1, 0)),
        Some("mountings") => mountings::mountings(number(0, 5), number(1, 0)),
        Some("rotors") => mountings::rotors(number(0, 2), number(1, 0)),
        _ => eprintln!(
            "usage: trials family|detect|confusion|nothing|grid|pairs|together|once|mountings|rotors [COUNT [FIRST]] [CODE…]"
        ),
    }
}
