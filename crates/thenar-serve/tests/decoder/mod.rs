//! Reads model and snapshot messages, written from `docs/protocol.md` and nothing else.

#![allow(dead_code)] // each test file uses its part

use serde_json::Value;

fn take<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    bytes[at..at + N].try_into().unwrap()
}

pub fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes(take(bytes, at))
}

pub fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(take(bytes, at))
}

pub fn f32_at(bytes: &[u8], at: usize) -> f64 {
    f64::from(f32::from_le_bytes(take(bytes, at)))
}

pub fn f64_at(bytes: &[u8], at: usize) -> f64 {
    f64::from_le_bytes(take(bytes, at))
}

/// A model message.
pub struct Model {
    pub epoch: u32,
    pub json: Value,
    arrays: Vec<u8>,
}

impl Model {
    pub fn read(bytes: &[u8]) -> Self {
        assert_eq!(bytes[..4], [1, 3, 0, 0], "kind, version, flags");
        let length = u32_at(bytes, 8) as usize;
        assert_eq!(length % 4, 0);
        assert_eq!(u32_at(bytes, 12), 0);
        let json = serde_json::from_slice(&bytes[16..16 + length]).unwrap();
        Self { epoch: u32_at(bytes, 4), json, arrays: bytes[16 + length..].to_vec() }
    }

    /// Elements of the array that the JSON pointer leads to.
    pub fn array(&self, pointer: &str) -> Vec<Vec<f64>> {
        let entry = self.json.pointer(pointer).unwrap_or_else(|| panic!("no {pointer}"));
        let number = |key: &str| entry[key].as_u64().unwrap() as usize;
        let (offset, count, width) = (number("offset"), number("count"), number("width"));
        assert_eq!(offset % 4, 0, "{pointer} is aligned");
        let one = |k: usize| -> f64 {
            match entry["type"].as_str().unwrap() {
                "f32" => f32_at(&self.arrays, offset + 4 * k),
                "u32" => f64::from(u32_at(&self.arrays, offset + 4 * k)),
                "u16" => f64::from(u16_at(&self.arrays, offset + 2 * k)),
                "u8" => f64::from(self.arrays[offset + k]),
                other => panic!("type {other}"),
            }
        };
        (0..count).map(|i| (0..width).map(|j| one(i * width + j)).collect()).collect()
    }

    /// Length of a list.
    pub fn count(&self, pointer: &str) -> usize {
        self.json.pointer(pointer).and_then(Value::as_array).map_or(0, Vec::len)
    }
}

/// A contact of a snapshot.
#[derive(Clone, Debug)]
pub struct Contact {
    pub bodies: [u16; 2],
    pub vertices: [u16; 2],
    pub place: [f64; 3],
    pub force: [f64; 3],
    pub normal: [f64; 3],
    pub area: f64,
    pub slip: f64,
    pub gap: f64,
}

/// A snapshot message.
#[derive(Clone, Debug)]
pub struct Snapshot {
    pub flags: u16,
    pub epoch: u32,
    pub number: u32,
    pub steps: u32,
    pub time: f64,
    pub cost_ms: f64,
    pub budget_ms: f64,
    pub speed: f64,
    pub energy: [f64; 3],
    pub penetration: f64,
    pub joint_gap: f64,
    pub pose: u32,
    pub sweeps: u32,
    pub rigids: Vec<[f64; 7]>,
    pub nodes: Vec<[f64; 3]>,
    pub targets: Vec<[f64; 7]>,
    pub loads: Vec<[f64; 24]>,
    pub contacts: Vec<Contact>,
}

impl Snapshot {
    pub fn read(bytes: &[u8]) -> Self {
        assert_eq!(bytes[..2], [2, 3], "kind, version");
        let count = |k: usize| u32_at(bytes, 64 + 4 * k) as usize;
        let mut at = 88;
        let rigids = many::<7>(bytes, &mut at, count(0));
        let nodes = many::<3>(bytes, &mut at, count(1));
        let targets = many::<7>(bytes, &mut at, count(2));
        let loads = many::<24>(bytes, &mut at, count(4));
        let contacts = (0..count(3)).map(|k| contact(bytes, at + 48 * k)).collect();
        assert_eq!(bytes.len(), at + 48 * count(3), "nothing left over");
        assert_eq!(u32_at(bytes, 84), 0);
        Self {
            flags: u16_at(bytes, 2),
            epoch: u32_at(bytes, 4),
            number: u32_at(bytes, 8),
            steps: u32_at(bytes, 12),
            time: f64_at(bytes, 16),
            cost_ms: f32_at(bytes, 24),
            budget_ms: f32_at(bytes, 28),
            speed: f32_at(bytes, 32),
            energy: [36, 40, 44].map(|at| f32_at(bytes, at)),
            penetration: f32_at(bytes, 48),
            joint_gap: f32_at(bytes, 52),
            pose: u32_at(bytes, 56),
            sweeps: u32_at(bytes, 60),
            rigids,
            nodes,
            targets,
            loads,
            contacts,
        }
    }

    /// Vertices of the surface that the JSON pointer leads to (`…/render` or `…/collision`).
    pub fn embed(&self, model: &Model, soft: usize, surface: &str) -> Vec<[f64; 3]> {
        let soft = format!("/softs/{soft}");
        let start = model.json.pointer(&format!("{soft}/node_start")).unwrap().as_u64().unwrap();
        let tets = model.array(&format!("{soft}/tets"));
        let carriers = model.array(&format!("{soft}/{surface}/tets"));
        let weights = model.array(&format!("{soft}/{surface}/weights"));
        let node = |n: f64| &self.nodes[start as usize + n as usize];
        let place = |(carrier, weights): (&Vec<f64>, &Vec<f64>)| {
            let tet = &tets[carrier[0] as usize];
            std::array::from_fn(|x| (0..4).map(|k| weights[k] * node(tet[k])[x]).sum())
        };
        carriers.iter().zip(&weights).map(place).collect()
    }
}

fn many<const N: usize>(bytes: &[u8], at: &mut usize, count: usize) -> Vec<[f64; N]> {
    let from = *at;
    *at += 4 * N * count;
    (0..count).map(|i| std::array::from_fn(|k| f32_at(bytes, from + 4 * (N * i + k)))).collect()
}

impl Contact {
    /// Normal part of the force.
    pub fn normal_force(&self) -> f64 {
        (0..3).map(|k| self.force[k] * self.normal[k]).sum()
    }
}

/// A unit vector from two numbers.
fn octahedral(folded: [i16; 2]) -> [f64; 3] {
    let [u, v] = folded.map(|x| f64::from(x) / 32767.0);
    let z = 1.0 - u.abs() - v.abs();
    let t = (-z).max(0.0);
    let [x, y] = [u - t.copysign(u), v - t.copysign(v)];
    let length = (x * x + y * y + z * z).sqrt();
    [x, y, z].map(|part| part / length)
}

fn contact(bytes: &[u8], at: usize) -> Contact {
    Contact {
        bodies: [u16_at(bytes, at), u16_at(bytes, at + 2)],
        vertices: [u16_at(bytes, at + 4), u16_at(bytes, at + 6)],
        place: [8, 12, 16].map(|k| f32_at(bytes, at + k)),
        force: [20, 24, 28].map(|k| f32_at(bytes, at + k)),
        normal: octahedral([32, 34].map(|k| u16_at(bytes, at + k) as i16)),
        area: f32_at(bytes, at + 36),
        slip: f32_at(bytes, at + 40),
        gap: f32_at(bytes, at + 44),
    }
}
