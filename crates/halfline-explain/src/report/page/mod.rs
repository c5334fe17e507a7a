//! The page that shows a walk: one HTML file with everything in it, which works from a disk.
//!
//! The page is `walk.html`; its style and its scripts lie beside it, and each script has one thing
//! to do: `projection.js` brings the mesh to the screen, `replay.js` sums up the steps, `brush.js`,
//! `drawing.js` and `ray.js` draw them in space, `picture.js` draws the lecture's cases, `words.js`
//! writes, and `walk.js` listens to the keys. The explanation goes in as JSON.

use crate::markup::escape;

const TEMPLATE: &str = include_str!("walk.html");
const STYLE: &str = include_str!("walk.css");

/// The scripts, each of which uses those before it.
const SCRIPTS: [&str; 7] = [
    include_str!("projection.js"),
    include_str!("replay.js"),
    include_str!("brush.js"),
    include_str!("drawing.js"),
    include_str!("ray.js"),
    include_str!("picture.js"),
    include_str!("words.js"),
];
const LAST_SCRIPT: &str = include_str!("walk.js");

/// The page of an explanation.
pub fn page(title: &str, data: &serde_json::Value) -> String {
    let title = escape(title);
    let data = escape_for_script(&data.to_string());
    let script = SCRIPTS.join("\n") + "\n" + LAST_SCRIPT;
    let value = |name: &str| match name {
        "title" => title.as_str(),
        "data" => data.as_str(),
        "style" => STYLE,
        "script" => script.as_str(),
        _ => unreachable!("the template has no other placeholders"),
    };
    // Read the template once from front to back, so that what goes in is never taken for it.
    let mut page = String::with_capacity(TEMPLATE.len() + STYLE.len() + script.len() + data.len());
    let mut rest = TEMPLATE;
    while let Some((before, after)) = rest.split_once("{{") {
        let (name, after) = after.split_once("}}").expect("placeholders end");
        page.push_str(before);
        page.push_str(value(name));
        rest = after;
    }
    page + rest
}

/// JSON that may stand in a script element: `<` could end or comment out the element, and the line
/// separators U+2028 and U+2029 end lines in older scripts. In JSON they occur within strings only,
/// where each may be written as a number.
fn escape_for_script(json: &str) -> String {
    json.replace('<', "\\u003c").replace('\u{2028}', "\\u2028").replace('\u{2029}', "\\u2029")
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::page;

    #[test]
    fn the_page_holds_title_data_style_and_scripts() {
        let page = page("dragon.ply", &json!({"format": 1, "steps": [0.25]}));
        assert_eq!(page.matches("dragon.ply").count(), 2);
        assert!(page.contains(r#"id="walk-data">{"format":1,"steps":[0.25]}</script>"#));
        assert!(page.contains("--near:"));
        assert!(page.contains("class Frame"));
        assert!(page.contains("goTo(readHash()"));
        assert!(page.ends_with("</html>\n"));
    }

    #[test]
    fn a_title_is_text() {
        let page = page(r#"<script>"&'</script>"#, &json!({}));
        assert!(page.contains("<h1>&lt;script&gt;&quot;&amp;&#39;&lt;/script&gt;</h1>"));
    }

    #[test]
    fn data_can_neither_end_its_element_nor_comment_it_out() {
        let name = "</script><!--<script>\u{2028}\u{2029}";
        let data = json!({ "name": name });
        let page = page("", &data);
        let written = page.split_once(r#"id="walk-data">"#).unwrap().1;
        let written = written.split_once("</script>").unwrap().0;
        assert!(!written.contains(['<', '\u{2028}', '\u{2029}']));
        assert_eq!(serde_json::from_str::<serde_json::Value>(written).unwrap(), data);
    }

    #[test]
    fn placeholders_in_what_goes_in_stay_as_they_are() {
        let page = page("{{data}}", &json!({"name": "{{title}} {{nothing}}"}));
        assert!(page.contains("<h1>{{data}}</h1>"));
        assert!(page.contains(r#"{"name":"{{title}} {{nothing}}"}"#));
    }

    #[test]
    fn nothing_comes_from_elsewhere() {
        let page = page("", &json!({}));
        assert!(page.contains("default-src 'none'"));
        let addresses: Vec<&str> = page.split("http").skip(1).collect();
        // The one address is a name: that of SVG.
        assert!(
            addresses
                .iter()
                .all(|a| a.starts_with("://www.w3.org/2000/svg\"") || a.starts_with("-equiv"))
        );
    }
}
