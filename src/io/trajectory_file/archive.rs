//! Trajectories as NumPy arrays.

use super::table::{State, row, rows, states};
use crate::trajectory::{FourierSeries, Trajectory};
use npyz::WriterBuilder;
use std::io::{Cursor, Write};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// `time` (N), and `q`, `qd`, `qdd` (N × n).
pub(super) fn npz(series: &FourierSeries, rate_hz: f64, periods: usize) -> Result<Vec<u8>, String> {
    let all: Vec<State> = (0..rows(series, rate_hz, periods))
        .map(|k| states(row(series, rate_hz, k)))
        .collect();
    let (count, joints) = (all.len() as u64, series.joints() as u64);
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let mut put = |name: &str, shape: &[u64], values: &mut dyn Iterator<Item = f64>| -> Result<(), String> {
        let wrong = |e: &dyn std::fmt::Display| e.to_string();
        archive
            .start_file(format!("{name}.npy"), SimpleFileOptions::default())
            .map_err(|e| wrong(&e))?;
        let mut bytes = Vec::new();
        let options = npyz::WriteOptions::new().default_dtype().shape(shape).writer(&mut bytes);
        let mut writer = options.begin_nd().map_err(|e| wrong(&e))?;
        writer.extend(values).map_err(|e| wrong(&e))?;
        writer.finish().map_err(|e| wrong(&e))?;
        archive.write_all(&bytes).map_err(|e| wrong(&e))
    };
    put("time", &[count], &mut all.iter().map(|s| s.time))?;
    for (k, name) in ["q", "qd", "qdd"].into_iter().enumerate() {
        put(name, &[count, joints], &mut all.iter().flat_map(|s| s.of[k].iter().copied()))?;
    }
    archive.finish().map(Cursor::into_inner).map_err(|e| e.to_string())
}
