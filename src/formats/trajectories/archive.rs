//! Trajectories as NumPy arrays.

use super::table::{Course, states};
use crate::trajectory::Trajectory;
use npyz::WriterBuilder;
use std::io::Cursor;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// `time` (N), and `q`, `qd`, `qdd` (N × n).
pub(super) fn npz(course: &Course) -> Result<Vec<u8>, String> {
    // Rows are computed again for every array: all of them would be as large as the file.
    let all = || (0..course.rows()).map(|k| states(course.row(k)));
    let (count, joints) = (course.rows() as u64, course.series.joints() as u64);
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let mut put = |name: &str, shape: &[u64], values: &mut dyn Iterator<Item = f64>| -> Result<(), String> {
        let wrong = |e: &dyn std::fmt::Display| e.to_string();
        archive
            .start_file(format!("{name}.npy"), SimpleFileOptions::default())
            .map_err(|e| wrong(&e))?;
        let options = npyz::WriteOptions::new().default_dtype().shape(shape).writer(&mut archive);
        let mut writer = options.begin_nd().map_err(|e| wrong(&e))?;
        writer.extend(values).map_err(|e| wrong(&e))?;
        writer.finish().map_err(|e| wrong(&e))
    };
    put("time", &[count], &mut all().map(|s| s.time))?;
    for (k, name) in ["q", "qd", "qdd"].into_iter().enumerate() {
        put(name, &[count, joints], &mut all().flat_map(|s| s.of[k].clone()))?;
    }
    archive.finish().map(Cursor::into_inner).map_err(|e| e.to_string())
}
