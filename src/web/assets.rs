//! Files inside the program.

use flate2::Compression;
use flate2::write::GzEncoder;
use rust_embed::RustEmbed;
use std::borrow::Cow;
use std::io::Write;
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

/// plotly.js, plain and packed: 4.6 MB and 1.4 MB.
static PLOTLY: LazyLock<(Vec<u8>, Vec<u8>)> = LazyLock::new(|| {
    let plain = plotly_js().into_bytes();
    let packed = packed(&plain);
    (plain, packed)
});

/// three.js, packed: 0.65 MB and 0.17 MB.
static THREE: LazyLock<Vec<u8>> = LazyLock::new(|| packed(text("three.js").as_bytes()));

fn packed(plain: &[u8]) -> Vec<u8> {
    let mut packer = GzEncoder::new(Vec::new(), Compression::default());
    let packed = packer.write_all(plain).and_then(|()| packer.finish());
    packed.expect("writing to memory cannot fail")
}

/// The first of the script elements that the crate hands out; the second is MathJax, which the pages do without.
fn plotly_js() -> String {
    let elements = plotly::Plot::offline_js_sources();
    let start = elements.find('>').map_or(0, |at| at + 1);
    let end = elements[start..].find("</script>\n").map_or(elements.len(), |at| start + at);
    elements[start..end].to_string()
}

/// The file called `name`.
pub(super) fn asset(name: &str) -> Option<Asset> {
    if name == "plotly.js" {
        let (plain, packed) = &*PLOTLY;
        return Some(Asset {
            media_type: media_type(name).to_string(),
            etag: format!("\"plotly-{}\"", plain.len()),
            plain: Cow::Borrowed(plain),
            gzip: Some(packed),
        });
    }
    let file = Files::get(name)?;
    let packed = (name == "three.js").then(|| THREE.as_slice());
    let hash = file.metadata.sha256_hash();
    let etag = hash[..12]
        .iter()
        .fold(String::from("\""), |text, byte| format!("{text}{byte:02x}"));
    Some(Asset {
        media_type: media_type(name).to_string(),
        etag: etag + "\"",
        plain: file.data,
        gzip: packed,
    })
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
        let text = plotly_js();
        assert!(text.starts_with("/**\n* plotly.js v"), "{}", &text[..80]);
        assert!(!text.contains("MathJax.loader") && text.len() > 4_000_000);
    }
}
