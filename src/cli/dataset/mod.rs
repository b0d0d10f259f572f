//! `raindrops dataset`: many views of a scene or a plate, with and without rain, as layers, and what is in them.
//!
//! A view depends on the scene, the options and its number alone, so shards need not know of each other: together they
//! are what one run makes, byte for byte, on the same device. A view is there when its `view.json` is, which is
//! written last; the manifest is made of those, by whoever finds all of them there.

mod maker;
mod set;

use std::path::PathBuf;

use anyhow::Context as _;
use clap::Args;

use self::maker::{Maker, Plans};
use self::set::Set;
use super::interrupt::{Interrupted, heed_interrupts, is_interrupted};
use super::options::PictureArgs;
use super::render::parse_grid;
use super::tell::say;
use super::{Answer, progress, say_doubt};
use crate::Result;
use crate::files::write_whole;
use crate::renderer::parts::Grid;
use crate::thousands::counted;

/// Draw many views with and without rain, as a data set
///
/// Each view is written as layers, with and without rain, and stands in a manifest: docs/data-set.md.
#[derive(Args)]
pub struct DatasetArgs {
    /// Folder to write into; views that exist already stay
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Number of views [default: the frames of the scene's film, or 100]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=9_999_999))]
    views: Option<u32>,
    /// Turn the camera about the vertical, by another angle of up to this many degrees in each view [default: 180; 0 with a
    /// background or a film's camera]
    #[arg(long, value_name = "DEGREES", value_parser = parse_turn)]
    turn: Option<f64>,
    /// Give each view a rain rate between these, in mm/h, spread evenly over the logarithm [default: the scene's rate]
    #[arg(long, value_name = "LOW,HIGH", value_parser = parse_range)]
    rates: Option<[f64; 2]>,
    /// Look through a pane in the rain that was wiped so many seconds before each view, spread evenly over the logarithm: the
    /// scene's, or one that leans before the camera
    #[arg(long, value_name = "LOW,HIGH", value_parser = parse_range)]
    pane_ages: Option<[f64; 2]>,
    /// Make every Nth view only, starting with the Ith: for the Ith of N machines
    #[arg(long, value_name = "I/N", value_parser = parse_shard, default_value = "1/1")]
    shard: Shard,
    /// Write no list of the drops in view, which may take many times the space of the pictures
    #[arg(long)]
    no_drop_lists: bool,
    /// Write for each view what masks are made of: how much light single drops take, and how far the picture is from one in
    /// which all rain is a medium
    #[arg(long)]
    masks: bool,
    /// Draw each picture in this many parts, with the same result: for pictures larger than the device's images
    #[arg(long, value_name = "CxR", value_parser = parse_grid)]
    tiles: Option<Grid>,
    #[command(flatten)]
    picture: PictureArgs,
}

/// The views of one machine.
#[derive(Clone, Copy)]
struct Shard {
    /// From 1 on.
    number: u32,
    of: u32,
}

/// Runs the command.
pub fn run(args: &DatasetArgs) -> anyhow::Result<Answer> {
    let set = Set::new(args)?;
    // Even where nothing is left to draw, the folder must not hold views of another set.
    set.is_begun()?;
    let mine: Vec<u32> = (0..set.views)
        .filter(|view| view % args.shard.of == args.shard.number - 1)
        .filter(|view| !set.has(*view))
        .collect();
    if !mine.is_empty() {
        let device = args.picture.device.open()?;
        let plans = Plans::of(&set)?;
        say_doubt(&plans.rainy);
        // What cannot be drawn is known before anything is written.
        let mut made = Maker::new(&set, &device, &plans, args.tiles)?;
        set.begin()?;
        heed_interrupts()?;
        let bar = progress(mine.len() as u64, "views");
        for (done, view) in mine.iter().enumerate() {
            if is_interrupted() {
                let left = mine.len() - done;
                let left = counted(left as u64, "view");
                let left = format!("{left} missing; the same command goes on");
                return Err(Interrupted).context(left);
            }
            made.view(*view)?;
            bar.inc(1);
        }
        bar.finish_and_clear();
        device.instance().expect_silence()?;
    }
    let missing = (0..set.views).filter(|view| !set.has(*view)).count();
    if missing > 0 {
        say!(
            "{} made; {missing} of {} left to other shards, the last of which to end writes the manifest",
            counted(mine.len() as u64, "view"),
            set.views
        );
        return Ok(Answer::Yes);
    }
    let lines = (0..set.views).map(|view| set.line(view)).collect::<Result<Vec<_>>>()?;
    let manifest = set.folder.join("manifest.jsonl");
    write_whole(&manifest, lines.concat().as_bytes())?;
    say!("{}: {}", counted(set.views.into(), "view"), manifest.display());
    Ok(Answer::Yes)
}

/// `2/8` to the second of eight.
fn parse_shard(text: &str) -> std::result::Result<Shard, String> {
    text.split_once('/')
        .and_then(|(number, of)| Some(Shard { number: number.parse().ok()?, of: of.parse().ok()? }))
        .filter(|shard| shard.number > 0 && shard.number <= shard.of)
        .ok_or_else(|| format!("'{text}' is not a shard from 1/N to N/N"))
}

fn parse_turn(text: &str) -> std::result::Result<f64, String> {
    text.parse()
        .ok()
        .filter(|degrees| (0.0..=180.0).contains(degrees))
        .ok_or("give 0 to 180 degrees".into())
}

/// `2,50`.
fn parse_range(text: &str) -> std::result::Result<[f64; 2], String> {
    let number = |text: &str| text.parse().ok().filter(|one: &f64| one.is_finite() && *one > 0.0);
    text.split_once(',')
        .and_then(|(low, high)| Some([number(low)?, number(high)?]))
        .filter(|[low, high]| low <= high)
        .ok_or_else(|| {
            format!("'{text}' is not two numbers over 0, the lower one first, like 2,50")
        })
}

#[cfg(test)]
mod tests {
    use super::{parse_range, parse_shard, parse_turn};

    #[test]
    fn ranges_shards_and_turns_have_both_ends() {
        assert_eq!(parse_range("2,50"), Ok([2.0, 50.0]));
        assert_eq!(parse_range("0.5,0.5"), Ok([0.5, 0.5]));
        for text in ["0,1", "-1,1", "1,0", "3,2", "1,inf", "NaN,1", "1", "1,2,3", "", "a,b"] {
            assert!(parse_range(text).is_err(), "{text}");
        }
        let shard = |text| parse_shard(text).map(|shard| (shard.number, shard.of));
        assert_eq!((shard("1/1"), shard("3/3")), (Ok((1, 1)), Ok((3, 3))));
        for text in ["0/1", "0/0", "2/1", "-1/2", "1", "1/2/3"] {
            assert!(shard(text).is_err(), "{text}");
        }
        assert_eq!((parse_turn("0"), parse_turn("180")), (Ok(0.0), Ok(180.0)));
        for text in ["-1", "180.5", "NaN", "x"] {
            assert!(parse_turn(text).is_err(), "{text}");
        }
    }
}
