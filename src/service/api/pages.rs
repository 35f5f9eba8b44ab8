//! `/`: where a person who opens the address in a browser finds the way.

use axum::response::Html;

const LANDING: &str = include_str!("landing.html");

pub async fn landing() -> Html<&'static str> {
    Html(LANDING)
}
