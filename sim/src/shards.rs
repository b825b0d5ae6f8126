//! Files of shards: the rows of a base plane that one machine of several has rendered, and what is needed to make the picture.
//!
//! A line of JSON, then the rows as zlib data: for each row red, green, blue and transparency of all its pixels, u32, least
//! significant byte first.

use std::io::{Read as _, Write as _};

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use serde::{Deserialize, Serialize};
use slicecast::format::Step;
use slicecast::warp::Warp;
use slicecast_engine::camera::{PICTURE_SIDE_MAX, Picture};
use slicecast_engine::frame::Prepared;
use slicecast_engine::image::{BaseImage, Frame};
use slicecast_engine::key;
use slicecast_engine::picture::of_base;
use slicecast_engine::shard::Shard;
use slicecast_engine::simd::Simd;
use slicecast_engine::tile::TILE_ROWS;
use slicecast_scene::PrecisionName;

/// The version of the files.
const VERSION: u32 = 1;
/// The longest first line.
const HEADER_MAX: usize = 1 << 16;
/// Pixels of the largest base plane.
const PIXELS_MAX: u64 = 1 << 28;

/// Why a file is not a shard of the frame.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShardError {
    /// Not such a file.
    #[error("not a shard; expected a file that `slicecast render --shard` wrote")]
    Foreign,
    /// Of another version of the program.
    #[error("a shard of version {0}; this program reads version {VERSION}")]
    Version(u32),
    /// Numbers that no shard has.
    #[error("a damaged shard: {0}")]
    Damaged(&'static str),
    /// Of another frame.
    #[error("of another frame than {0}; expected shards of one scene on one volume, by one version of slicecast")]
    Other(String),
    /// Given twice.
    #[error("shard {number}/{count} again; {first} is the same one")]
    Twice {
        /// Its number.
        number: u32,
        /// Of how many.
        count: u32,
        /// The file before.
        first: String,
    },
    /// Not given.
    #[error("{given} of {count} shards; missing: {missing}")]
    Missing {
        /// Files given.
        given: usize,
        /// Shards of the frame.
        count: u32,
        /// Numbers of the others.
        missing: String,
    },
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Header {
    slicecast_shard: u32,
    /// Number, from 1, and how many there are.
    shard: [u32; 2],
    #[serde(flatten)]
    frame: Framed,
    /// Of this line without it, and of the rows.
    crc32: u32,
}

impl Header {
    /// The checksum of the header and these rows.
    fn sum(&self, rows: &[u8]) -> u32 {
        let mut sum = crc32fast::Hasher::new();
        sum.update(format!("{:?} {:?}", self.shard, self.frame).as_bytes());
        sum.update(rows);
        sum.finalize()
    }
}

/// What all shards of a frame have in common.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Framed {
    /// The volume, the scene and the program.
    key: String,
    precision: String,
    format: String,
    one: u32,
    /// Pixels of the base plane, and rays per voxel along a side.
    size: [usize; 2],
    rays: usize,
    picture: [u32; 2],
    /// Origin, right, down: s31.32, and before rounding.
    warp: [[i64; 2]; 3],
    affine: [[f64; 2]; 3],
    background: [f64; 3],
}

/// What identifies a frame: the volume, the scene and the program's version.
fn key(prepared: &Prepared<'_>) -> String {
    let scene = format!("{:?}", prepared.scene);
    format!("{}-{:08x}", key::key(prepared), crc32fast::hash(scene.as_bytes()))
}

/// A shard of a prepared frame as a file.
pub fn file(prepared: &Prepared<'_>, base: &BaseImage, shard: Shard) -> std::io::Result<Vec<u8>> {
    let picture = &prepared.setup.picture;
    let Warp { origin, right, down } = picture.warp;
    let rays = prepared.setup.plan.sampling().rays_per_voxel as usize;
    let [width, height] = base.size;
    let mut rows = Vec::new();
    for row in shard.rows(height, rays) {
        for plane in &base.planes {
            let bits = &plane[row * width..(row + 1) * width];
            rows.extend(bits.iter().flat_map(|bits| bits.to_le_bytes()));
        }
    }
    let mut header = Header {
        slicecast_shard: VERSION,
        shard: [shard.number(), shard.count()],
        frame: Framed {
            key: key(prepared),
            precision: prepared.scene.precision.name().into(),
            format: base.format.into(),
            one: base.one,
            size: base.size,
            rays,
            picture: picture.size,
            warp: [origin, right, down].map(|at| at.map(Step::to_bits)),
            affine: picture.affine,
            background: prepared.scene.image.background,
        },
        crc32: 0,
    };
    header.crc32 = header.sum(&rows);
    let mut file = serde_json::to_vec(&header)?;
    file.push(b'\n');
    let mut encoder = ZlibEncoder::new(file, Compression::fast());
    encoder.write_all(&rows)?;
    encoder.finish()
}

/// Shards on their way to a frame.
#[derive(Debug, Default)]
pub struct Merged {
    frame: Option<(Framed, u32)>,
    /// The file of each shard.
    given: Vec<Option<String>>,
    planes: [Vec<u32>; 4],
}

impl Merged {
    /// Adds a shard's file.
    ///
    /// # Errors
    /// [`ShardError`] if it is none, or not one of the shards before.
    pub fn add(&mut self, name: &str, file: &[u8]) -> Result<(), ShardError> {
        let (header, data) = header(file)?;
        let [number, count] = header.shard;
        let [width, height] = header.frame.size;
        check(&header.frame)?;
        let strips = height.div_ceil(header.frame.rays).div_ceil(TILE_ROWS);
        let shard = Shard::new(number, count).filter(|_| count as usize <= strips);
        let shard = shard.ok_or(ShardError::Damaged("its number, or that of all shards"))?;
        let known = self.given.iter().flatten().next().cloned();
        let sum = header.crc32;
        let own: Vec<usize> = shard.rows(height, header.frame.rays).collect();
        let rows = inflate(data, own.len() * width * 16)?;
        if header.sum(&rows) != sum {
            return Err(ShardError::Damaged("its checksum is another"));
        }
        match &self.frame {
            None => {
                self.planes = [(); 4].map(|()| vec![0; width * height]);
                self.given = vec![None; count as usize];
                self.frame = Some((header.frame, count));
            }
            Some(frame) if *frame == (header.frame, count) => {}
            Some(_) => return Err(ShardError::Other(known.unwrap_or_default())),
        }
        if let Some(Some(first)) = self.given.get(number as usize - 1) {
            let first = first.clone();
            return Err(ShardError::Twice { number, count, first });
        }
        let mut words = rows.as_chunks::<4>().0.iter().map(|bytes| u32::from_le_bytes(*bytes));
        for row in own {
            for plane in &mut self.planes {
                for (bits, word) in plane[row * width..(row + 1) * width].iter_mut().zip(&mut words) {
                    *bits = word;
                }
            }
        }
        self.given[number as usize - 1] = Some(name.to_owned());
        Ok(())
    }

    /// The frame with its picture, the way to it, and the background.
    ///
    /// # Errors
    /// [`ShardError::Missing`] names the shards that have not been added.
    pub fn frame(self, simd: Simd) -> Result<(Frame, Picture, [f64; 3]), ShardError> {
        let (frame, count) = self.frame.ok_or(ShardError::Foreign)?;
        let missing: Vec<String> = (self.given.iter().enumerate())
            .filter(|(_, file)| file.is_none())
            .map(|(index, _)| (index + 1).to_string())
            .collect();
        if !missing.is_empty() {
            return Err(ShardError::Missing {
                given: self.given.len() - missing.len(),
                count,
                missing: missing.join(", "),
            });
        }
        let precision = precision(&frame.precision)?;
        let [origin, right, down] = frame.warp.map(|at| at.map(Step::from_bits));
        let picture = Picture {
            size: frame.picture,
            warp: Warp { origin, right, down },
            affine: frame.affine,
        };
        let base = BaseImage {
            size: frame.size,
            format: format(precision),
            one: frame.one,
            planes: self.planes,
        };
        let shown = of_base(&base, precision, &picture, frame.background, simd);
        Ok((Frame { base, picture: shown }, picture, frame.background))
    }
}

/// The first line, and what follows it.
fn header(file: &[u8]) -> Result<(Header, &[u8]), ShardError> {
    let end = file.iter().take(HEADER_MAX).position(|byte| *byte == b'\n');
    let (line, data) = file.split_at(end.ok_or(ShardError::Foreign)?);
    let version = serde_json::from_slice::<serde_json::Value>(line)
        .ok()
        .and_then(|value| value.get("slicecast_shard")?.as_u64())
        .ok_or(ShardError::Foreign)?;
    if version != u64::from(VERSION) {
        return Err(ShardError::Version(u32::try_from(version).unwrap_or(u32::MAX)));
    }
    let header = serde_json::from_slice(line).map_err(|_| ShardError::Damaged("its first line is not complete"))?;
    Ok((header, &data[1..]))
}

/// Refuses sizes that no frame has.
fn check(frame: &Framed) -> Result<(), ShardError> {
    let [width, height] = frame.size.map(|side| side as u64);
    let pixels = width
        .checked_mul(height)
        .filter(|pixels| (1..=PIXELS_MAX).contains(pixels));
    if pixels.is_none() || !(1..=8).contains(&frame.rays) {
        return Err(ShardError::Damaged("the size of its base plane"));
    }
    if frame.picture.iter().any(|side| !(1..=PICTURE_SIDE_MAX).contains(side)) {
        return Err(ShardError::Damaged("the size of its picture"));
    }
    let precision = precision(&frame.precision)?;
    if frame.format != format(precision) || frame.one != one(precision) {
        return Err(ShardError::Damaged("the format of its channels"));
    }
    Ok(())
}

fn precision(name: &str) -> Result<PrecisionName, ShardError> {
    let named = PrecisionName::ALL
        .into_iter()
        .find(|precision| precision.name() == name);
    named.ok_or(ShardError::Damaged("its precision"))
}

/// The name of a precision's channels.
fn format(precision: PrecisionName) -> &'static str {
    use slicecast::composite::Recurrence as _;
    use slicecast::precision::Precision as _;
    slicecast_engine::with_pixel!(precision, p => p.pixel().format())
}

/// The bits of 1.0.
fn one(precision: PrecisionName) -> u32 {
    use slicecast::composite::{Channel as _, Recurrence as _};
    use slicecast::precision::Precision as _;
    slicecast_engine::with_pixel!(precision, p => p.pixel().one().bits())
}

/// Data of exactly this length.
fn inflate(data: &[u8], len: usize) -> Result<Vec<u8>, ShardError> {
    let mut rows = Vec::new();
    // One byte more would be too many.
    let read = ZlibDecoder::new(data).take(len as u64 + 1).read_to_end(&mut rows);
    if read.is_err() || rows.len() != len {
        return Err(ShardError::Damaged("its rows are not complete"));
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slicecast_engine::frame::Layer;
    use slicecast_scene::file::built_in;
    use slicecast_scene::{Blend, Classification, Scene, Surface};
    use slicecast_volume::mapping::Window;
    use slicecast_volume::open::load;

    fn scenes() -> Vec<Scene> {
        let bone = built_in("ct-bone").unwrap();
        let mut scenes = Vec::new();
        for precision in PrecisionName::ALL {
            scenes.push(Scene {
                precision,
                ..bone.clone()
            });
        }
        let [first, ..] = &mut scenes[..] else { unreachable!() };
        first.sampling.rays_per_voxel = 2;
        scenes.push(Scene {
            blend: Blend::Maximum,
            lighting: None,
            ..bone.clone()
        });
        let face = slicecast_scene::Face {
            colour: [1.0, 0.5, 0.2],
            opacity: 0.5,
        };
        scenes.push(Scene {
            classification: Classification::None,
            surfaces: vec![Surface::of(200.0, face)],
            ..bone
        });
        scenes
    }

    #[test]
    fn shards_together_are_the_frame() {
        let volume = load(None, Window::Auto).unwrap().volume;
        for scene in scenes() {
            let prepared = Prepared::new(&scene, &volume).unwrap();
            let whole = prepared.render(Layer::Tiles(32), &|_, _| ()).unwrap();
            let mut merged = Merged::default();
            for number in [2, 3, 1] {
                let shard = Shard::new(number, 3).unwrap();
                let base = prepared.render_shard(shard, &|_, _| ()).unwrap();
                let file = file(&prepared, &base, shard).unwrap();
                merged.add(&number.to_string(), &file).unwrap();
            }
            let (frame, picture, background) = merged.frame(Simd::widest()).unwrap();
            assert!(frame == whole, "{:?}, {:?}", scene.precision, scene.blend);
            assert_eq!((picture, background), (prepared.setup.picture, scene.image.background));
        }
    }

    #[test]
    fn what_is_no_shard_of_the_frame_is_refused() {
        let volume = load(None, Window::Auto).unwrap().volume;
        let bone = built_in("ct-bone").unwrap();
        let mut turned = bone.clone();
        turned.view.azimuth += 1.0;
        let of = |scene: &Scene, number, count| {
            let prepared = Prepared::new(scene, &volume).unwrap();
            let shard = Shard::new(number, count).unwrap();
            let base = prepared.render_shard(shard, &|_, _| ()).unwrap();
            file(&prepared, &base, shard).unwrap()
        };
        let (one, two) = (of(&bone, 1, 3), of(&bone, 2, 3));
        let mut merged = Merged::default();
        merged.add("one", &one).unwrap();
        let first = || "one".to_owned();
        let (number, count) = (1, 3);
        let again = ShardError::Twice {
            number,
            count,
            first: first(),
        };
        assert_eq!(merged.add("again", &one), Err(again));
        assert_eq!(merged.add("b", &of(&turned, 2, 3)), Err(ShardError::Other(first())));
        assert_eq!(merged.add("b", &of(&bone, 2, 2)), Err(ShardError::Other(first())));
        assert_eq!(merged.add("b", b"P6 1 1 255\n"), Err(ShardError::Foreign));
        assert_eq!(merged.add("b", b""), Err(ShardError::Foreign));
        assert_eq!(
            merged.add("b", b"{\"slicecast_shard\":2}\n"),
            Err(ShardError::Version(2))
        );
        let cut = ShardError::Damaged("its rows are not complete");
        assert_eq!(merged.add("b", &two[..two.len() - 9]), Err(cut));
        let mut other = two.clone();
        let at = two.windows(8).position(|part| part == b"\"crc32\":").unwrap() + 8;
        other[at] = if other[at] == b'1' { b'2' } else { b'1' };
        let damaged = merged.add("b", &other).unwrap_err();
        assert!(matches!(damaged, ShardError::Damaged(_)), "{damaged}");
        // The first line: a background, and more shards than there are strips, which are no reason to allocate any.
        let edited = |from: &str, to: &str| {
            let text = two.iter().map(|byte| char::from(*byte)).collect::<String>();
            assert!(text.contains(from), "{from}");
            text.replacen(from, to, 1).chars().map(|c| c as u8).collect::<Vec<_>>()
        };
        let wrong = ShardError::Damaged("its checksum is another");
        assert_eq!(
            merged.add("b", &edited("\"background\":[0.0,", "\"background\":[0.5,")),
            Err(wrong)
        );
        let many = ShardError::Damaged("its number, or that of all shards");
        assert_eq!(
            merged.add("b", &edited("\"shard\":[2,3]", "\"shard\":[2,4294967295]")),
            Err(many)
        );
        // A file that was refused can be given again, whole.
        merged.add("two", &two).unwrap();
        let missing = ShardError::Missing {
            given: 2,
            count: 3,
            missing: "3".into(),
        };
        assert_eq!(merged.frame(Simd::widest()).err(), Some(missing));
    }
}
