//! Which channels of an OpenEXR file are its colour, and which its depth.
//!
//! Programs put everything that they know of a pixel into one file: beauty, albedo, normals, positions. The rules here
//! choose by name alone. Where names do not decide, the file is refused with the names that it has.

use exr::meta::header::Header;

/// Layers that are the finished picture, the surest name first, in small letters.
const BEAUTY: [&str; 4] = ["combined", "rgba", "beauty", "c"];

/// What is read of a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Choice {
    /// Number of the part.
    pub part: usize,
    /// Numbers of its channels: red, green and blue, or one.
    pub channels: Vec<usize>,
    /// What messages call it.
    pub name: String,
    /// Names of the layers that could have been read instead.
    pub others: Vec<String>,
}

/// The channels of a part whose names are alike up to their last point.
#[derive(Clone, Debug, Default)]
struct Layer {
    part: usize,
    /// `ViewLayer.Combined`; in a file of several parts with the part's name before it. Empty: the channels stand alone.
    name: String,
    /// Whether the channels' own names have no point.
    is_plain: bool,
    view: Option<String>,
    /// What channels are called behind the point, and their numbers.
    channels: Vec<(String, usize)>,
}

impl Layer {
    fn channel(&self, name: &str) -> Option<usize> {
        let exact = self.channels.iter().find(|(own, _)| own == name);
        let found = exact.or(self.channels.iter().find(|(own, _)| own.eq_ignore_ascii_case(name)));
        found.map(|(_, number)| *number)
    }

    fn has(&self, name: &str) -> bool {
        self.channel(name).is_some()
    }

    /// Red, green and blue.
    fn rgb(&self) -> Option<Vec<usize>> {
        let all = |names: [&str; 3]| names.map(|name| self.channel(name)).into_iter().collect();
        Option::or(all(["R", "G", "B"]), all(["red", "green", "blue"]))
    }

    /// Luminance that stands for all colours.
    fn luminance(&self) -> Option<Vec<usize>> {
        let is_alone = !["X", "Z", "RY", "BY"].iter().any(|name| self.has(name));
        self.channel("Y").filter(|_| is_alone).map(|number| vec![number])
    }

    /// A distance; not the third component of a vector.
    fn z(&self) -> Option<Vec<usize>> {
        let is_vector = self.has("X") && self.has("Y");
        self.channel("Z").filter(|_| !is_vector).map(|number| vec![number])
    }

    /// One number a pixel, such as a distance; none for a vector or a colour.
    fn scalar(&self) -> Option<Vec<usize>> {
        if self.has("X") && self.has("Y") || self.rgb().is_some() {
            return None;
        }
        let named = ["Z", "V", "Y", "R"].iter().find_map(|name| self.channel(name));
        named.map(|number| vec![number])
    }

    /// What the name is behind its last point, in small letters.
    fn last_name(&self) -> String {
        self.name.rsplit('.').next().unwrap_or_default().to_lowercase()
    }

    /// A channel's name with the layer's before it.
    fn full_name(&self, own: &str) -> String {
        if self.name.is_empty() { own.into() } else { format!("{}.{own}", self.name) }
    }

    /// What messages call it.
    fn title(&self) -> String {
        if !self.name.is_empty() {
            return self.name.clone();
        }
        if self.rgb().is_some() {
            return "R G B".into();
        }
        self.channels.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(" ")
    }

    /// Whether a user means it: its name, the end of it, or for channels without a layer `RGB`.
    fn is_called(&self, wanted: &str) -> bool {
        let (name, wanted) = (self.name.to_lowercase(), wanted.to_lowercase());
        let is_rgb = self.name.is_empty() && ["rgb", "rgba", ""].contains(&wanted.as_str());
        name == wanted || name.ends_with(&format!(".{wanted}")) || is_rgb && self.rgb().is_some()
    }

    fn choice(&self, channels: Vec<usize>, all: &[&Layer]) -> Choice {
        let others = all.iter().map(|layer| layer.title()).filter(|name| *name != self.title());
        Choice { part: self.part, channels, name: self.title(), others: others.collect() }
    }
}

/// All layers of a file.
fn layers(headers: &[Header]) -> Vec<Layer> {
    let mut layers: Vec<Layer> = Vec::new();
    for (part, header) in headers.iter().enumerate() {
        let title = header.own_attributes.layer_name.as_ref().map(ToString::to_string);
        let title = title.filter(|_| headers.len() > 1).unwrap_or_default();
        let view = header.own_attributes.view_name.as_ref().map(ToString::to_string);
        for (number, channel) in header.channels.list.iter().enumerate() {
            let full = channel.name.to_string();
            let (before, own) = full.rsplit_once('.').unwrap_or(("", &full));
            let name = match (title.as_str(), before) {
                ("", name) | (name, "") => name.to_string(),
                (title, name) if name == title || name.starts_with(&format!("{title}.")) => {
                    name.to_string()
                }
                (title, name) => format!("{title}.{name}"),
            };
            let entry = (own.to_string(), number);
            match layers.iter_mut().find(|layer| layer.part == part && layer.name == name) {
                Some(layer) => layer.channels.push(entry),
                None => layers.push(Layer {
                    part,
                    name,
                    is_plain: before.is_empty(),
                    view: view.clone(),
                    channels: vec![entry],
                }),
            }
        }
    }
    layers
}

/// What a file has, for a message.
fn names(layers: &[Layer]) -> String {
    const MOST: usize = 12;
    let mut names: Vec<String> = Vec::new();
    for layer in layers {
        names.extend(layer.channels.iter().map(|(own, _)| layer.full_name(own)));
    }
    let more = names.len().saturating_sub(MOST);
    names.truncate(MOST);
    match (names.is_empty(), more) {
        (true, _) => "none".into(),
        (false, 0) => names.join(", "),
        (false, more) => format!("{} and {more} more", names.join(", ")),
    }
}

/// The one of these that is meant where several would do: of several views the first one's.
fn only<'a>(found: &[&'a Layer]) -> Option<&'a Layer> {
    let (first, rest) = found.split_first()?;
    let is_other_view = |other: &&Layer| first.view.is_some() && other.view != first.view;
    rest.iter().all(is_other_view).then_some(first)
}

/// Refuses a file in which several layers could be meant.
fn ambiguous(what: &str, found: &[&Layer], key: &str) -> String {
    let names: Vec<String> = found.iter().map(|layer| layer.title()).collect();
    format!("has several {what} layers: {}; choose one by {key}", names.join(", "))
}

/// The layer that a user names.
fn wanted<'a>(layers: &'a [Layer], name: &str, key: &str) -> Result<&'a Layer, String> {
    let exact: Vec<&Layer> = layers.iter().filter(|layer| layer.name == name).collect();
    let called: Vec<&Layer> = layers.iter().filter(|layer| layer.is_called(name)).collect();
    let found = if exact.is_empty() { called } else { exact };
    match found[..] {
        [] => Err(format!("has no layer '{name}', which {key} names; it has {}", names(layers))),
        _ => only(&found).ok_or_else(|| ambiguous(&format!("'{name}'"), &found, key)),
    }
}

/// The channels of a file's colour: `R G B`, else a layer named as the finished picture, else the only one; without
/// any the luminance. `name` chooses a layer, and `key` is what a message calls that choice.
pub(super) fn color(headers: &[Header], name: Option<&str>, key: &str) -> Result<Choice, String> {
    let layers = layers(headers);
    if let Some(name) = name {
        let layer = wanted(&layers, name, key)?;
        let channels = layer.rgb().or_else(|| layer.luminance());
        let channels = channels.ok_or_else(|| format!("has no colour in its layer '{name}'"))?;
        return Ok(layer.choice(channels, &[]));
    }
    let colors: Vec<&Layer> = layers.iter().filter(|layer| layer.rgb().is_some()).collect();
    let mut found: Vec<&Layer> =
        colors.iter().filter(|layer| layer.name.is_empty()).copied().collect();
    for name in BEAUTY {
        if found.is_empty() {
            found = colors.iter().filter(|layer| layer.last_name() == name).copied().collect();
        }
    }
    let found = if found.is_empty() { colors.clone() } else { found };
    if !found.is_empty() {
        let layer = only(&found).ok_or_else(|| ambiguous("colour", &found, key))?;
        return Ok(layer.choice(layer.rgb().unwrap_or_default(), &colors));
    }
    let grey: Vec<&Layer> = layers.iter().filter(|layer| layer.luminance().is_some()).collect();
    if let Some(layer) = only(&grey) {
        return Ok(layer.choice(layer.luminance().unwrap_or_default(), &grey));
    }
    if !grey.is_empty() {
        return Err(ambiguous("luminance", &grey, key));
    }
    if layers.iter().any(|layer| layer.has("Y") && (layer.has("RY") || layer.has("BY"))) {
        return Err("holds luminance and chroma (Y, RY, BY); save it with channels R, G, B".into());
    }
    Err(format!("has no channels R, G, B, nor Y; it has {}", names(&layers)))
}

/// The channels of a file's depth: `Z`, else a layer named depth; of a file without colour its only number, such as `V` or
/// `Y`, else red, green and blue, which must be equal. A `Z` beside `X` and `Y` is a vector's. `name` and `key` are as for
/// [`color`]; a name may be that of a channel, too.
pub(super) fn depth(headers: &[Header], name: Option<&str>, key: &str) -> Result<Choice, String> {
    let layers = layers(headers);
    if let Some(name) = name {
        return wanted_depth(&layers, name, key);
    }
    let number = |layer: &Layer| layer.scalar().or_else(|| layer.rgb());
    let is_named = |name: &str| name.to_lowercase().ends_with("depth");
    let own_name = |layer: &Layer| {
        let found = layer.channels.iter().find(|(name, _)| is_named(name));
        found.map(|(_, number)| vec![*number])
    };
    let colors = layers.iter().filter(|layer| layer.rgb().is_some()).count();
    type Rule<'a> = &'a dyn Fn(&Layer) -> Option<Vec<usize>>;
    let rules: [Rule<'_>; 7] = [
        &|layer| layer.z().filter(|_| layer.is_plain),
        &|layer| number(layer).filter(|_| layer.name.eq_ignore_ascii_case("depth")),
        &|layer| number(layer).filter(|_| layer.last_name() == "depth"),
        &|layer| own_name(layer).filter(|_| layer.is_plain),
        &|layer| number(layer).filter(|_| is_named(&layer.name)),
        &|layer| layer.scalar().filter(|_| layer.is_plain && colors == 0),
        &|layer| layer.rgb().filter(|_| layers.len() == 1),
    ];
    for rule in rules {
        let found: Vec<&Layer> = layers.iter().filter(|layer| rule(layer).is_some()).collect();
        if !found.is_empty() {
            let layer = only(&found).ok_or_else(|| ambiguous("depth", &found, key))?;
            return Ok(layer.choice(rule(layer).unwrap_or_default(), &found));
        }
    }
    let names = names(&layers);
    Err(format!(
        "has no depth, such as a channel Z or Depth.Z; it has {names}; choose one by {key}"
    ))
}

/// The depth that a user names: a whole channel, or a layer.
fn wanted_depth(layers: &[Layer], name: &str, key: &str) -> Result<Choice, String> {
    for layer in layers {
        let channel = layer.channels.iter().find(|(own, _)| layer.full_name(own) == name);
        if let Some((_, number)) = channel {
            return Ok(Choice { name: name.into(), ..layer.choice(vec![*number], &[]) });
        }
    }
    let layer = wanted(layers, name, key)?;
    let channels = layer.scalar().or_else(|| layer.rgb()).ok_or_else(|| {
        format!("has a vector in its layer '{name}'; {key} takes one channel of it: '{name}.Z'")
    })?;
    Ok(layer.choice(channels, &[]))
}

#[cfg(test)]
mod tests {
    use exr::math::Vec2;
    use exr::meta::attribute::{ChannelDescription, SampleType};

    use super::*;

    type Part<'a> = (&'a str, &'a [&'a str]);

    /// Parts with these names and channels.
    fn file(parts: &[Part<'_>]) -> Vec<Header> {
        let part = |(name, channels): &Part<'_>| {
            let mut sorted = channels.to_vec();
            sorted.sort_unstable();
            let list =
                sorted.iter().map(|name| ChannelDescription::new(*name, SampleType::F32, false));
            Header::new((*name).into(), Vec2(1, 1), list.collect())
        };
        parts.iter().map(part).collect()
    }

    type Rule = fn(&[Header], Option<&str>, &str) -> Result<Choice, String>;

    /// Channels of what a rule finds, or what it says.
    fn found(rule: Rule, parts: &[Part<'_>], name: Option<&str>) -> Result<String, String> {
        let headers = file(parts);
        let choice = rule(&headers, name, "the key")?;
        let channels = choice
            .channels
            .iter()
            .map(|number| headers[choice.part].channels.list[*number].name.to_string());
        Ok(channels.collect::<Vec<_>>().join(" "))
    }

    fn of<'a>(channels: &'a [&'a str]) -> [Part<'a>; 1] {
        [("", channels)]
    }

    #[test]
    fn colour_is_the_finished_picture() {
        let finds = |parts: &[Part<'_>], expected: &str| {
            assert_eq!(found(color, parts, None).as_deref(), Ok(expected), "{parts:?}");
        };
        finds(&of(&["A", "B", "G", "R", "left.R", "left.G", "left.B"]), "R G B");
        finds(&of(&["b", "g", "r"]), "r g b");
        finds(&of(&["blue", "green", "red"]), "red green blue");
        finds(
            &of(&["V.AO.R", "V.AO.G", "V.AO.B", "V.Combined.R", "V.Combined.G", "V.Combined.B"]),
            "V.Combined.R V.Combined.G V.Combined.B",
        );
        finds(
            &of(&["C.R", "C.G", "C.B", "A.R", "A.G", "A.B", "BEAUTY.R", "BEAUTY.G", "BEAUTY.B"]),
            "BEAUTY.R BEAUTY.G BEAUTY.B",
        );
        finds(
            &of(&["diffuse.R", "diffuse.G", "diffuse.B", "N.X", "N.Y", "N.Z"]),
            "diffuse.R diffuse.G diffuse.B",
        );
        finds(&of(&["N.X", "N.Y", "N.Z", "Y", "A"]), "Y");
        finds(&[("albedo", &["R", "G", "B"]), ("rgba", &["R", "G", "B", "A"])], "R G B");
        let parts: [Part<'_>; 2] = [("albedo", &["R", "G", "B"]), ("rgba", &["R", "G", "B"])];
        assert_eq!(color(&file(&parts), None, "").map(|choice| choice.part), Ok(1));

        let refused = |parts: &[Part<'_>], expected: &str| {
            let said = found(color, parts, None).expect_err("ambiguous");
            assert!(said.contains(expected), "{said}");
        };
        let two = ["diffuse.R", "diffuse.G", "diffuse.B", "gloss.R", "gloss.G", "gloss.B"];
        refused(&of(&two), "several colour layers: diffuse, gloss; choose one by the key");
        let two = ["a.C.R", "a.C.G", "a.C.B", "b.C.R", "b.C.G", "b.C.B"];
        refused(&of(&two), "a.C, b.C");
        refused(&[("a", &["R", "G", "B"]), ("b", &["R", "G", "B"])], "a, b");
        refused(
            &of(&["N.X", "N.Y", "N.Z"]),
            "has no channels R, G, B, nor Y; it has N.X, N.Y, N.Z",
        );
        refused(&of(&["Y", "RY", "BY"]), "luminance and chroma");
    }

    #[test]
    fn depth_is_no_part_of_a_vector() {
        let finds = |parts: &[Part<'_>], expected: &str| {
            assert_eq!(found(depth, parts, None).as_deref(), Ok(expected), "{parts:?}");
        };
        finds(&of(&["A.Z", "A.Y", "A.X", "R", "G", "B", "Z"]), "Z");
        finds(&of(&["R", "G", "B", "N.X", "N.Y", "N.Z", "depth.Z"]), "depth.Z");
        finds(&of(&["depth.Z", "View.Depth.Z"]), "depth.Z");
        finds(
            &of(&[
                "V.Combined.R",
                "V.Combined.G",
                "V.Combined.B",
                "V.Denoising Depth.Z",
                "V.Depth.Z",
                "V.Mist.Z",
            ]),
            "V.Depth.Z",
        );
        finds(&of(&["V.Depth.V", "V.Noise.V", "R", "G", "B"]), "V.Depth.V");
        finds(
            &of(&["R", "G", "B", "VRayZDepth.R", "VRayZDepth.G", "VRayZDepth.B"]),
            "VRayZDepth.R VRayZDepth.G VRayZDepth.B",
        );
        finds(&of(&["R", "G", "B", "zdepth", "X"]), "zdepth");
        for alone in ["V", "Y", "R", "z"] {
            finds(&of(&[alone, "A"]), alone);
        }
        finds(&of(&["R", "G", "B"]), "R G B");
        finds(&[("rgba", &["R", "G", "B"]), ("N", &["X", "Y", "Z"]), ("depth", &["Z"])], "Z");

        let refused = |parts: &[Part<'_>], expected: &str| {
            let said = found(depth, parts, None).expect_err("no depth");
            assert!(said.contains(expected), "{said}");
        };
        refused(&of(&["R", "G", "B", "N.X", "N.Y", "N.Z"]), "has no depth");
        refused(&of(&["R", "G", "B", "V.Mist.Z"]), "has no depth");
        refused(&of(&["X", "Y", "Z"]), "has no depth");
        refused(&of(&["a.Depth.Z", "b.Depth.Z"]), "several depth layers: a.Depth, b.Depth");
    }

    #[test]
    fn a_user_chooses_by_name() {
        let parts = of(&[
            "V.AO.R",
            "V.AO.G",
            "V.AO.B",
            "R",
            "G",
            "B",
            "N.X",
            "N.Y",
            "N.Z",
            "V.Mist.Z",
            "P.Depth.Z",
            "Q.Depth.Z",
        ]);
        for (name, expected) in
            [("V.AO", "V.AO.R V.AO.G V.AO.B"), ("ao", "V.AO.R V.AO.G V.AO.B"), ("RGB", "R G B")]
        {
            assert_eq!(found(color, &parts, Some(name)).as_deref(), Ok(expected), "{name}");
        }
        for (name, expected) in [
            ("Mist", "V.Mist.Z"),
            ("N.Z", "N.Z"),
            ("Q.Depth", "Q.Depth.Z"),
            ("V.Mist.Z", "V.Mist.Z"),
        ] {
            assert_eq!(found(depth, &parts, Some(name)).as_deref(), Ok(expected), "{name}");
        }
        let refused = |rule, name, expected: &str| {
            let said = found(rule, &parts, Some(name)).expect_err("nothing");
            assert!(said.contains(expected), "{said}");
        };
        refused(color, "beauty", "has no layer 'beauty', which the key names; it has B, G, R, N.X");
        refused(color, "N", "has no colour in its layer 'N'");
        refused(depth, "Depth", "has several 'Depth' layers: P.Depth, Q.Depth");
        refused(
            depth,
            "N",
            "has a vector in its layer 'N'; the key takes one channel of it: 'N.Z'",
        );
    }

    #[test]
    fn of_several_views_the_first_is_read() {
        let mut headers = file(&[("rgba.l", &["R", "G", "B"]), ("rgba.r", &["R", "G", "B"])]);
        assert!(color(&headers, None, "").is_err());
        headers[0].own_attributes.view_name = Some("left".into());
        headers[1].own_attributes.view_name = Some("right".into());
        assert_eq!(color(&headers, None, "").map(|choice| choice.part), Ok(0));
    }
}
