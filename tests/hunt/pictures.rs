//! Pictures of random scenes, told apart: by them `tests/house/generated` sees whether a fault in a shader changes anything.

use std::hash::{DefaultHasher, Hash as _, Hasher as _};

use raindrops::scene::model::Preset;

use crate::common::{folder, on_device};
use crate::drawn::hunt;
use crate::folder::{read, write};
use crate::models::Model;
use crate::scene::make;

/// How many scenes, of a seed that no other test has.
const SCENES: u64 = 50;
const SEED: u64 = 45;

#[test]
#[ignore = "run by scripts/mutants.sh --generated, which compares what it prints; a minute or more"]
fn digests_of_random_scenes() {
    on_device(|device| {
        let hunt = hunt(device, None);
        for number in 0..SCENES {
            let place = folder();
            write(&make(SEED, number), place.path()).expect("a scene");
            let loaded =
                read(&place.path().join("scene.toml"), &hunt.photographs).expect("a scene");
            for preset in [Preset::Fast, Preset::Exact] {
                let model = Model::new(&hunt.place, &loaded.scene, &loaded.environment, preset);
                let mut digest = DefaultHasher::new();
                match model.and_then(|model| model.draw(1)) {
                    Ok(drawn) => {
                        bytemuck::cast_slice::<_, u8>(&drawn.picture.pixels).hash(&mut digest)
                    }
                    Err(refused) => refused.to_string().hash(&mut digest),
                }
                println!("picture {number} {preset:?} {:016x}", digest.finish());
            }
        }
    });
}
