//! Files inside the program.

use super::{bibliography, glossary};
use flate2::Compression;
use flate2::read::GzDecoder;
use flate2::write::GzEncoder;
use rust_embed::RustEmbed;
use sha2::{Digest, Sha256};
use std::borrow::Cow;
use std::io::{Read, Write};
use std::sync::LazyLock;

#[derive(RustEmbed)]
#[folder = "src/web/assets"]
#[exclude = "*.md"]
struct Files;

/// A file as it is sent.
pub(super) struct Asset {
    pub media_type: String,
    pub etag: String,
    pub plain: Cow<'static, [u8]>,
    /// Packed beforehand, where packing it for every answer would take long.
    pub gzip: Option<&'static [u8]>,
}

/// plotly.js 3.0.1 as its makers hand it out, packed by `gzip -9 -n`: 1.4 MB of 4.6 MB. The program holds no other copy.
const PLOTLY_GZIP: &[u8] = include_bytes!("vendor/plotly.min.js.gz");

/// The same for who takes no packed answers.
static PLOTLY: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let mut plain = Vec::new();
    let read = GzDecoder::new(PLOTLY_GZIP).read_to_end(&mut plain);
    read.expect("packed when it was checked in");
    plain
});

/// three.js, packed: 0.65 MB and 0.17 MB.
static THREE: LazyLock<Vec<u8>> = LazyLock::new(|| packed(text("three.js").as_bytes()));

fn packed(plain: &[u8]) -> Vec<u8> {
    let mut packer = GzEncoder::new(Vec::new(), Compression::default());
    let packed = packer.write_all(plain).and_then(|()| packer.finish());
    packed.expect("writing to memory cannot fail")
}

/// The file called `name`.
pub(super) fn asset(name: &str) -> Option<Asset> {
    if name == "plotly.js" {
        return Some(Asset {
            media_type: media_type(name).to_string(),
            etag: "\"plotly-3.0.1\"".to_string(),
            plain: Cow::Borrowed(&PLOTLY),
            gzip: Some(PLOTLY_GZIP),
        });
    }
    let made: [(&str, &'static str); 2] = [
        (glossary::NAME, &glossary::EFFECTS),
        (bibliography::NAME, &bibliography::SOURCES),
    ];
    if let Some((_, text)) = made.into_iter().find(|(own, _)| *own == name) {
        return Some(Asset {
            media_type: media_type(name).to_string(),
            etag: etag(&Sha256::digest(text.as_bytes())),
            plain: Cow::Borrowed(text.as_bytes()),
            gzip: None,
        });
    }
    let file = Files::get(name)?;
    let packed = (name == "three.js").then(|| THREE.as_slice());
    Some(Asset {
        media_type: media_type(name).to_string(),
        etag: etag(&file.metadata.sha256_hash()),
        plain: file.data,
        gzip: packed,
    })
}

fn etag(hash: &[u8]) -> String {
    let start = String::from("\"");
    hash[..12].iter().fold(start, |text, byte| format!("{text}{byte:02x}")) + "\""
}

/// The text of a file that is known to be there.
pub(super) fn text(name: &str) -> String {
    let file = Files::get(name).unwrap_or_else(|| panic!("{name} is embedded"));
    String::from_utf8(file.data.into_owned()).expect("pages are UTF-8")
}

fn media_type(name: &str) -> &'static str {
    match name.rsplit('.').next() {
        Some("js") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("json") => "application/json",
        Some("html") => "text/html; charset=utf-8",
        Some("svg") => "image/svg+xml",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plotly_is_whole_and_alone() {
        let text = String::from_utf8(PLOTLY.clone()).expect("a script is UTF-8");
        assert!(text.starts_with("/**\n* plotly.js v3.0.1\n"), "{}", &text[..80]);
        assert!(!text.contains("MathJax.loader") && text.len() > 4_000_000);
    }
}
