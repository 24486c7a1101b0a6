//! Checkpoints: one file that holds everything a run needs to go on to the same bits.
//!
//! A checkpoint is taken in the middle of a step, when nodes have moved and forces wait to be evaluated. Nothing that
//! the forces depend on is then anywhere but in the state, whatever the law does to its bonds.
//!
//! The file: `PDLANGCK`, version (u32), fingerprint of the scene (u64), of the layout (u64), checksum (CRC-32) and
//! length of what follows (u64), all little-endian; then a zlib stream of the snapshot.

use crate::contact::Reaction;
use crate::engine::State;
use crate::error::InputError;
use crate::spectrum::StableStep;
use flate2::{Compression, Crc};
use serde::{Deserialize, Serialize};
use std::io::{Read, Write};
use std::path::Path;

const MAGIC: &[u8; 8] = b"PDLANGCK";
const VERSION: u32 = 6;
const HEADER: usize = 8 + 4 + 8 + 8 + 4 + 8;

/// What a run needs to go on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    pub state: State,
    pub clock: Clock,
    /// How the step was found.
    pub stable: Option<StableStep>,
    /// Stages of the fields in a step.
    pub stages: u32,
    /// Directed bonds broken so far, and when the step was last found.
    pub broken: u64,
    pub broken_at_measure: u64,
    /// Kinetic and strain energy at the start [J].
    pub initial_energy: f64,
    /// Work of conditions so far, and what has left through matching boundaries [J].
    pub work: f64,
    pub left: f64,
    pub reactions: Vec<Reaction>,
}

/// Time as a number of equal steps since the step was last chosen, so that it does not drift.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Clock {
    pub base_step: u64,
    /// [s]
    pub base_time: f64,
    /// [s]
    pub dt: f64,
}

impl Clock {
    pub fn time(&self, step: u64) -> f64 {
        self.base_time + (step - self.base_step) as f64 * self.dt
    }
}

/// What a checkpoint belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Body, law and conditions.
    pub scene: u64,
    /// Order of the nodes in memory: traversal and lane width.
    pub layout: u64,
}

/// Writes a checkpoint; a file of that name is replaced only when the new one is complete.
pub fn write(path: &Path, identity: Identity, snapshot: &Snapshot) -> std::io::Result<()> {
    let plain = postcard::to_stdvec(snapshot).map_err(std::io::Error::other)?;
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(&plain)?;
    let payload = encoder.finish()?;
    let mut bytes = Vec::with_capacity(HEADER + payload.len());
    bytes.extend(MAGIC);
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(identity.scene.to_le_bytes());
    bytes.extend(identity.layout.to_le_bytes());
    bytes.extend(checksum(&payload).to_le_bytes());
    bytes.extend((payload.len() as u64).to_le_bytes());
    bytes.extend(payload);
    replace(path, &bytes)
}

/// Writes beside the file, then renames: readers see the old file or the new one.
pub fn replace(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut beside = path.as_os_str().to_owned();
    beside.push(".partial");
    let mut file = std::fs::File::create(&beside)?;
    file.write_all(bytes)?;
    file.sync_all()?;
    std::fs::rename(&beside, path)
}

/// Reads a checkpoint of the given scene and layout.
///
/// Errors: a file that cannot be read, is no checkpoint, is damaged, or belongs to another scene or layout.
pub fn read(path: &Path, identity: Identity) -> Result<Snapshot, InputError> {
    let bytes = std::fs::read(path).map_err(|e| {
        InputError::new(
            format!("cannot read {}: {e}", path.display()),
            "check the path of the checkpoint",
        )
    })?;
    parse(&bytes, identity)
        .map_err(|e| InputError::new(format!("{}: {}", path.display(), e.what), e.remedy))
}

fn parse(bytes: &[u8], identity: Identity) -> Result<Snapshot, InputError> {
    if bytes.len() < HEADER || &bytes[..8] != MAGIC {
        return Err(InputError::new(
            "this is not a checkpoint",
            "give a file written by a run's checkpoints",
        ));
    }
    let word = |at: usize| u64::from_le_bytes(std::array::from_fn(|k| bytes[at + k]));
    let half = |at: usize| u32::from_le_bytes(std::array::from_fn(|k| bytes[at + k]));
    if half(8) != VERSION {
        return Err(InputError::new(
            format!(
                "the checkpoint has format {}, this program reads format {VERSION}",
                half(8)
            ),
            "resume with the program that wrote it, or start anew",
        ));
    }
    let payload = &bytes[HEADER..];
    if payload.len() as u64 != word(32) || checksum(payload) != half(28) {
        return Err(damaged());
    }
    if word(12) != identity.scene {
        return Err(InputError::new(
            "the checkpoint belongs to another scene: body, law, parameters or conditions differ",
            "resume with the scene that wrote it; only the end of the run, its step and its outputs may change",
        ));
    }
    if word(20) != identity.layout {
        return Err(InputError::new(
            "the checkpoint was written with another traversal, precision or instruction set",
            "name in the scene what it was written with",
        ));
    }
    let mut plain = Vec::new();
    flate2::read::ZlibDecoder::new(payload)
        .read_to_end(&mut plain)
        .map_err(|_| damaged())?;
    postcard::from_bytes(&plain).map_err(|_| damaged())
}

fn damaged() -> InputError {
    InputError::new(
        "the checkpoint is damaged or incomplete",
        "use an earlier checkpoint of the run",
    )
}

fn checksum(bytes: &[u8]) -> u32 {
    let mut crc = Crc::new();
    crc.update(bytes);
    crc.sum()
}

/// A number that tells scenes apart (FNV-1a).
#[derive(Clone, Copy, Debug)]
pub struct Fingerprint(pub u64);

impl Default for Fingerprint {
    fn default() -> Fingerprint {
        Fingerprint(0xcbf2_9ce4_8422_2325)
    }
}

impl Fingerprint {
    pub fn bytes(&mut self, bytes: &[u8]) {
        for b in bytes {
            self.0 = (self.0 ^ u64::from(*b)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    pub fn number(&mut self, x: f64) {
        self.bytes(&x.to_bits().to_le_bytes());
    }

    /// Whatever a value prints as.
    pub fn debug(&mut self, value: &impl std::fmt::Debug) {
        self.bytes(format!("{value:?}").as_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn snapshot() -> Snapshot {
        let state = State {
            step: 7,
            time: 0.25,
            dt: 2.5e-8,
            u: vec![vec![1.0, -0.0, f64::MIN_POSITIVE]],
            v: vec![vec![0.1; 3]],
            slots: vec![],
            families: vec![],
        };
        Snapshot {
            state,
            clock: Clock {
                base_step: 0,
                base_time: 0.0,
                dt: 0.25 / 7.0,
            },
            stages: 0,
            stable: None,
            broken: 3,
            broken_at_measure: 0,
            initial_energy: 1.5,
            work: -2.0,
            left: 0.5,
            reactions: vec![Reaction {
                depth: 1e-3,
                ..Reaction::default()
            }],
        }
    }

    const HERE: Identity = Identity {
        scene: 5,
        layout: 6,
    };

    fn file() -> Vec<u8> {
        let path =
            std::env::temp_dir().join(format!("checkpoint-{:?}.test", std::thread::current().id()));
        write(&path, HERE, &snapshot()).unwrap();
        assert_eq!(read(&path, HERE).unwrap(), snapshot());
        let bytes = std::fs::read(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        bytes
    }

    #[test]
    fn every_damaged_byte_is_noticed() {
        let bytes = file();
        for k in 0..bytes.len() {
            let mut bad = bytes.clone();
            bad[k] ^= 0x10;
            assert!(parse(&bad, HERE).is_err(), "byte {k}");
            assert!(parse(&bytes[..k], HERE).is_err(), "cut at {k}");
        }
    }

    #[test]
    fn another_scene_is_refused_by_name() {
        let bytes = file();
        let message = |scene, layout| {
            parse(&bytes, Identity { scene, layout })
                .unwrap_err()
                .to_string()
        };
        assert!(message(4, 6).contains("another scene"));
        assert!(message(5, 7).contains("another traversal, precision"));
        let missing = read(Path::new("no such file"), HERE)
            .unwrap_err()
            .to_string();
        assert!(missing.starts_with("cannot read no such file"));
    }

    #[test]
    fn time_does_not_drift() {
        let clock = Clock {
            base_step: 10,
            base_time: 1.0,
            dt: 0.1,
        };
        assert_eq!(clock.time(10), 1.0);
        assert_eq!(clock.time(1_000_010), 1.0 + 1e6 * 0.1);
    }
}
