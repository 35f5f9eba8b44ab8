//! What a file is, by its first bytes: names of files say nothing here.

/// What its first bytes make of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Text,
    /// Text of two bytes per character, whose first two say in which order.
    Utf16,
    Npz,
    Matlab,
    Parquet,
    Mcap,
    Sqlite,
    Foreign(Foreign),
}

/// A format that is known and not read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Foreign {
    pub what: &'static str,
    pub remedy: &'static str,
}

const AS_CSV: &str = "export it as CSV: one row per sample, with a header that names the columns";
const UNPACK: &str = "unpack it, or pack it with gzip or Zstandard instead";
const ARRAYS: &str = "save the arrays with their names: numpy.savez_compressed('log.npz', time=t, q=q, tau=tau)";
const OLDER_MATLAB: &str = "save it as version 7: save('log.mat', …, '-v7')";
const ROS_1: &str = "convert it: `rosbags-convert --src log.bag --dst log` makes a ROS 2 bag";

/// First bytes, what they are of, and what to do.
const FOREIGN: &[(&[u8], &str, &str)] = &[
    (b"\x93NUMPY", "a NumPy array without names", ARRAYS),
    (
        b"\x89HDF\r\n\x1a\n",
        "an HDF5 file",
        "for MATLAB, save it as version 7: save('log.mat', …, '-v7'); else export it as CSV",
    ),
    (b"MATLAB 7.3", "a MATLAB 7.3 file (HDF5)", OLDER_MATLAB),
    (b"#ROSBAG", "a ROS 1 bag", ROS_1),
    (b"ULog", "a ULog recording", "convert it with `ulog2csv`"),
    (b"\xd0\xcf\x11\xe0", "an old Excel or Word file", AS_CSV),
    (b"BZh", "a bzip2 file", UNPACK),
    (b"\xfd7zXZ", "an xz file", UNPACK),
    (b"7z\xbc\xaf", "a 7z archive", UNPACK),
    (b"Rar!", "a RAR archive", UNPACK),
    (
        b"ARROW1",
        "an Arrow or Feather file",
        "save it as Parquet: frame.to_parquet('log.parquet')",
    ),
    (b"TDSm", "a TDMS file of LabVIEW", AS_CSV),
    (b"MDF     ", "an MDF file", AS_CSV),
    (b"%PDF", "a PDF", AS_CSV),
    (b"\x89PNG", "a picture", AS_CSV),
    (b"\xff\xd8\xff", "a picture", AS_CSV),
    (b"\x7fELF", "a program", "give the log instead"),
    (b"\x80\x04\x95", "a Python pickle", ARRAYS),
    (b"\x80\x05\x95", "a Python pickle", ARRAYS),
    (b"{", "a JSON document", AS_CSV),
    (b"<", "an XML document", AS_CSV),
];
const BINARY: Foreign = Foreign {
    what: "a binary file of an unknown kind",
    remedy: "logs are CSV, NPZ, MATLAB (up to version 7), Parquet, MCAP or rosbag2, plain, gzip or Zstandard",
};
#[cfg(not(feature = "formats"))]
const NOT_BUILT: &str = "this build reads text only (it lacks the feature `formats`)";

impl Kind {
    /// Of a file whose first bytes, some thousand of them, are `start`.
    pub fn from_start(start: &[u8]) -> Self {
        if start.starts_with(b"\xff\xfe") || start.starts_with(b"\xfe\xff") {
            return Self::Utf16;
        }
        let read: [(&[u8], Self); 5] = [
            (b"PK\x03\x04", Self::Npz),
            (b"PAR1", Self::Parquet),
            (b"\x89MCAP0\r\n", Self::Mcap),
            (b"SQLite format 3\0", Self::Sqlite),
            (b"MATLAB 5.0 MAT-file", Self::Matlab),
        ];
        if let Some((_, kind)) = read.into_iter().find(|(magic, _)| start.starts_with(magic)) {
            return kind;
        }
        let text = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start).trim_ascii_start();
        let foreign = FOREIGN
            .iter()
            .find(|(magic, ..)| start.starts_with(magic) || text.starts_with(magic));
        if let Some(&(_, what, remedy)) = foreign {
            return Self::Foreign(Foreign { what, remedy });
        }
        if start.contains(&0) {
            Self::Foreign(BINARY)
        } else {
            Self::Text
        }
    }

    #[cfg(not(feature = "formats"))]
    pub fn as_not_built(self) -> Foreign {
        let what = match self {
            Self::Npz => "a ZIP archive (NPZ)",
            Self::Matlab => "a MATLAB file",
            Self::Parquet => "a Parquet file",
            Self::Mcap => "an MCAP recording",
            _ => "an SQLite database",
        };
        Foreign { what, remedy: NOT_BUILT }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_what_their_first_bytes_say() {
        assert_eq!(Kind::from_start(b"time,q1\n0,1\n"), Kind::Text);
        assert_eq!(Kind::from_start(b"\xff\xfet\0"), Kind::Utf16);
        assert_eq!(Kind::from_start(b"PAR1\x15"), Kind::Parquet);
        assert!(matches!(Kind::from_start(b"\x89PNG\r\n"), Kind::Foreign(f) if f.what == "a picture"));
        assert!(matches!(Kind::from_start(b"\n {\"a\": 1}"), Kind::Foreign(f) if f.what == "a JSON document"));
        assert!(matches!(Kind::from_start(b"\x01\x02\0\x03"), Kind::Foreign(f) if f.what.starts_with("a binary file")));
    }
}
