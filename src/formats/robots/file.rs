//! A robot from the bytes of a file.

use crate::formats::json::{Malformed, Parsed, parse};
use encoding_rs::Encoding;
use flate2::read::MultiGzDecoder;
use quick_xml::events::Event;
use serde_json::json;
use std::borrow::Cow;
use std::io::Read;

/// Bytes that a compressed robot file may unpack to: the largest URDF files, with all their meshes' names, are a hundredth.
const LARGEST_FILE: u64 = 64 << 20;

/// A robot document from the bytes of a file: JSON, or URDF or MJCF if it starts like XML; each may be packed by gzip.
///
/// # Errors
/// Text that is neither, or in another encoding than it says.
pub fn robot_file(bytes: &[u8]) -> Result<Parsed, Malformed> {
    if bytes.starts_with(&[0x1f, 0x8b]) {
        return robot_file(&unpacked(bytes)?);
    }
    let wide = Encoding::for_bom(bytes).is_some_and(|(encoding, _)| encoding != encoding_rs::UTF_8);
    let start = bytes
        .iter()
        .find(|b| !b.is_ascii_whitespace() && !b"\xef\xbb\xbf".contains(b));
    if !wide && start != Some(&b'<') {
        return parse(bytes);
    }
    let xml = xml_text(bytes)?;
    if !xml.trim_start().starts_with('<') {
        return parse(xml.as_bytes());
    }
    let xml = xml.trim_start_matches('\u{feff}');
    let kind = if is_mjcf(xml) { "mjcf" } else { "urdf" };
    Ok(Parsed {
        value: json!({kind: xml}),
        problems: Vec::new(),
    })
}

/// Whether the first element is `<mujoco>`.
fn is_mjcf(xml: &str) -> bool {
    let mut reader = quick_xml::Reader::from_str(xml);
    loop {
        match reader.read_event() {
            Ok(Event::Start(tag) | Event::Empty(tag)) => return tag.name().as_ref() == b"mujoco",
            Ok(Event::Eof) | Err(_) => return false,
            Ok(_) => {}
        }
    }
}

fn malformed(detail: String, hint: &str) -> Malformed {
    Malformed {
        detail,
        hint: Some(hint.to_string()),
    }
}

fn unpacked(bytes: &[u8]) -> Result<Vec<u8>, Malformed> {
    let mut text = Vec::new();
    let read = MultiGzDecoder::new(bytes).take(LARGEST_FILE + 1).read_to_end(&mut text);
    let refuse = |detail: String| malformed(detail, "send it as plain text");
    read.map_err(|e| refuse(format!("the file cannot be unpacked: {e}")))?;
    if text.len() as u64 > LARGEST_FILE {
        return Err(refuse(format!("the file unpacks to more than {} MiB", LARGEST_FILE >> 20)));
    }
    // One packing is enough: a file in a file in a file is no robot.
    match text.starts_with(&[0x1f, 0x8b]) {
        true => Err(refuse("the file is packed twice".into())),
        false => Ok(text),
    }
}

/// The text in the encoding that a byte-order mark or the XML declaration names, UTF-8 otherwise.
fn xml_text(bytes: &[u8]) -> Result<Cow<'_, str>, Malformed> {
    let declared = declared_encoding(bytes);
    let encoding = match (Encoding::for_bom(bytes), &declared) {
        (Some((encoding, _)), _) => encoding,
        (None, Some(name)) => Encoding::for_label(name.as_bytes()).ok_or_else(|| {
            let detail = format!("the file says that it is in the encoding `{name}`, which is not known");
            malformed(detail, "save it as UTF-8")
        })?,
        (None, None) => encoding_rs::UTF_8,
    };
    // A declaration of UTF-16 in a file of single bytes was copied from elsewhere.
    let encoding = if encoding.is_ascii_compatible() || Encoding::for_bom(bytes).is_some() {
        encoding
    } else {
        encoding_rs::UTF_8
    };
    let (text, _, has_errors) = encoding.decode(bytes);
    if !has_errors {
        return Ok(text);
    }
    let line =
        std::str::from_utf8(bytes).map_or_else(|e| 1 + memchr::memchr_iter(b'\n', &bytes[..e.valid_up_to()]).count(), |_| 1);
    Err(malformed(
        format!("the file is not {} text (line {line})", encoding.name()),
        "save it as UTF-8, or name its encoding in the first line: <?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>",
    ))
}

/// The encoding that `<?xml … encoding="…"?>` names within the first bytes.
fn declared_encoding(bytes: &[u8]) -> Option<String> {
    let start = String::from_utf8_lossy(&bytes[..bytes.len().min(1024)]);
    let declaration = &start[start.find("<?xml")?..];
    let declaration = &declaration[..declaration.find("?>")?];
    let value = declaration[declaration.find("encoding")? + 8..]
        .trim_start()
        .strip_prefix('=')?
        .trim_start();
    let quote = value.chars().next().filter(|c| ['"', '\''].contains(c))?;
    value[1..].split(quote).next().map(str::to_string)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(bytes: &[u8]) -> Result<String, String> {
        match robot_file(bytes) {
            Ok(parsed) => Ok(parsed.value["urdf"].as_str().unwrap_or("no XML").to_string()),
            Err(e) => Err(e.detail),
        }
    }

    #[test]
    fn files_are_read_in_the_encoding_that_they_name() {
        let latin = b"<?xml version=\"1.0\" encoding='ISO-8859-1'?>\n<robot name=\"gr\xfcn\"/>";
        assert!(text(latin).unwrap().contains("grün"));
        let wide: Vec<u8> = "\u{feff}<robot name=\"grün\"/>"
            .encode_utf16()
            .flat_map(u16::to_le_bytes)
            .collect();
        assert!(text(&wide).unwrap().starts_with("<robot name=\"grün\""));
        assert_eq!(text("\u{feff} <robot/>".as_bytes()).unwrap().trim(), "<robot/>");
        let unnamed = text(b"<robot>\n<link name=\"gr\xfcn\"/></robot>").unwrap_err();
        assert_eq!(unnamed, "the file is not UTF-8 text (line 2)");
        assert!(
            text(b"<?xml version='1.0' encoding='klingon'?><robot/>")
                .unwrap_err()
                .contains("`klingon`")
        );
    }

    #[test]
    fn packed_files_are_read_up_to_a_limit() {
        use flate2::Compression;
        use flate2::write::GzEncoder;
        use std::io::Write;
        let pack = |bytes: &[u8]| {
            let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
            encoder.write_all(bytes).unwrap();
            encoder.finish().unwrap()
        };
        assert_eq!(text(&pack(b"<robot/>")).unwrap(), "<robot/>");
        assert!(text(&pack(&pack(b"<robot/>"))).unwrap_err().contains("packed twice"));
        assert!(text(&pack(&vec![b' '; 65 << 20])).unwrap_err().contains("64 MiB"));
    }
}
