//! Trajectories as NumPy arrays.

use super::table::{Course, State, states};
use crate::trajectory::Trajectory;
use npyz::WriterBuilder;
use std::io::{Cursor, Write};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// `time` (N), and `q`, `qd`, `qdd` (N × n).
pub(super) fn npz(course: &Course) -> Result<Vec<u8>, String> {
    let all: Vec<State> = (0..course.rows()).map(|k| states(course.row(k))).collect();
    let (count, joints) = (all.len() as u64, course.series.joints() as u64);
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
