//! Fills the templates of HTML pages.

pub use minijinja::{Value, context};

use bathyscope_log::support::printable::xml;
use minijinja::syntax::SyntaxConfig;
use minijinja::{Environment, UndefinedBehavior};
use std::error::Error;

/// Fault of a template, such as the name of a value that it is not given.
#[derive(Debug, thiserror::Error)]
#[error("the page cannot be made: {0}")]
pub struct TemplateFault(String);

impl From<minijinja::Error> for TemplateFault {
    /// Names the fault in an included template after the place where the template is included.
    fn from(fault: minijinja::Error) -> Self {
        let faults = std::iter::successors(Some(&fault as &dyn Error), |fault| (*fault).source());
        Self(faults.map(ToString::to_string).collect::<Vec<String>>().join(": "))
    }
}

/// Template: its file name and its text.
pub type Template<'a> = (&'a str, &'a str);

/// Fills the first template, which may include the others. Texts are escaped, except those of
/// [`Value::from_safe_string`]; what is not known leaves an empty place.
///
/// # Errors
/// When a template cannot be read, or names a value that it is not given.
pub fn fill(templates: &[Template<'_>], values: Value) -> Result<String, TemplateFault> {
    let mut environment = Environment::new();
    // Lines with nothing but a block leave no trace.
    let syntax = SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build()?;
    environment.set_syntax(syntax);
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.set_formatter(|out, _, value| {
        if value.is_none() {
            return Ok(());
        }
        let text = value.to_string();
        Ok(out.write_str(&if value.is_safe() { text } else { xml(&text) })?)
    });
    for (name, text) in templates {
        environment.add_template(name, text)?;
    }
    let page = templates.first().map_or("", |(name, _)| *name);
    Ok(environment.get_template(page)?.render(values)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_escaped_and_nothing_is_left_where_nothing_is_known() {
        let page = "<p>{{ name }}{% include \"part.html\" %}{{ drawn }}</p>\n";
        let part = "\n{% if name %}\n<b>{{ unknown }}</b>\n{% endif %}\n";
        let values = context! {
            name => "<Anna> & 'co'\u{7}",
            unknown => None::<String>,
            drawn => Value::from_safe_string("<svg/>".to_owned()),
        };
        let filled = fill(&[("page.html", page), ("part.html", part)], values).unwrap();
        assert_eq!(filled, "<p>&lt;Anna&gt; &amp; &apos;co&apos;\n<b></b>\n<svg/></p>");
    }

    #[test]
    fn a_value_that_is_not_given_is_an_error_that_names_the_place() {
        let places =
            ["{{ depth }}", "{% if depth %}{% endif %}", "{% for a in depth %}{% endfor %}"];
        for place in places {
            let part = format!("<p>\n{place}</p>");
            let templates = [("page.html", "{% include \"part.html\" %}"), ("part.html", &part)];
            let fault = fill(&templates, context!(height => 1)).unwrap_err().to_string();
            assert!(fault.contains("page.html:1") && fault.contains("part.html:2"), "{fault}");
        }
    }
}
