//! What is needed to do an identification again.

use super::identify::cancelled;
use super::{CancelFlag, Code, Error, LogFile};
use crate::documents::{IdentifyRequest, LogOrigin, Provenance, written_robot};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::Read;

/// Request, robot, version, and the logs by their content.
///
/// # Errors
/// A log file that has become unreadable; `no_result` where `cancel` was set meanwhile.
pub(super) fn provenance(
    request: &IdentifyRequest,
    logs: &[LogFile],
    validation: &[LogFile],
    cancel: &CancelFlag,
) -> Result<Provenance, Error> {
    let with_role = |role: &'static str| move |log| origin(log, role, cancel);
    let origins = logs
        .iter()
        .map(with_role("identification"))
        .chain(validation.iter().map(with_role("validation")));
    Ok(Provenance {
        version: env!("CARGO_PKG_VERSION").into(),
        request: request.document.clone(),
        robot: Some(written_robot(&request.robot)),
        logs: origins.collect::<Result<_, _>>()?,
    })
}

fn origin(log: &LogFile, role: &'static str, cancel: &CancelFlag) -> Result<LogOrigin, Error> {
    let unreadable = |e: std::io::Error| Error::new(Code::FileUnreadable, format!("cannot read {}: {e}", log.name));
    let mut file = File::open(&log.path).map_err(unreadable)?;
    let (mut hash, mut bytes, mut part) = (Sha256::new(), 0, vec![0; 1 << 16]);
    loop {
        if cancel.is_cancelled() {
            return Err(cancelled("identification"));
        }
        let count = file.read(&mut part).map_err(unreadable)?;
        if count == 0 {
            break;
        }
        hash.update(&part[..count]);
        bytes += count as u64;
    }
    Ok(LogOrigin {
        file: log.name.clone(),
        role: role.into(),
        bytes,
        sha256: hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// FIPS 180-2, appendix B.1.
    #[test]
    fn val_logs_are_distinguished_by_sha_256() {
        let path = std::env::temp_dir().join(format!("dynident-hash-{}", std::process::id()));
        std::fs::write(&path, "abc").unwrap();
        let found = origin(&LogFile::at(&path), "validation", &CancelFlag::default()).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(found.bytes, 3);
        assert_eq!(
            found.sha256,
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }
}
