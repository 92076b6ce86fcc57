//! Checkpoints: what goes in comes out bit by bit, and no file, however damaged, does worse than a typed error.

use mechanics_core::checkpoint::{Checkpoint, CheckpointError, FORMAT_VERSION, Kind, crc64};
use mechanics_core::state::{State, StateHash};
use mechanics_core::tensor::{Mat3, Vec3};
use std::path::PathBuf;

/// Numbers whose bits are easily lost: signed zeros, subnormals, infinities, NaN with a payload.
fn delicate() -> Vec<f64> {
    vec![
        0.0,
        -0.0,
        5e-324,
        -f64::MIN_POSITIVE,
        f64::INFINITY,
        f64::NAN,
        f64::from_bits(0x7FF8_0000_DEAD_BEEF),
        0.1,
    ]
}

fn sample() -> Checkpoint {
    let mut checkpoint = Checkpoint::new();
    checkpoint.put("contact/stiffness", &delicate());
    checkpoint.put("particles/position", &[1.5f32, -0.0, f32::MIN_POSITIVE]);
    checkpoint.put("pairs", &[0u32, 7, u32::MAX]);
    checkpoint.put("random", &[u64::MAX, 1, 0x0123_4567_89AB_CDEF]);
    checkpoint.put("position", &[Vec3::new(1.0, 2.0, 3.0), Vec3::new(-0.0, 1e-300, 1e300)]);
    checkpoint.put("deformation", &[Mat3::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0)]);
    checkpoint.put::<f64>("nothing", &[]);
    checkpoint.put_text("scheme", "BDF2, κ adaptive");
    checkpoint.put_one("step", 12u64);
    checkpoint
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// A directory of this test's own, empty.
fn directory(name: &str) -> PathBuf {
    let directory = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("checkpoint-{name}"));
    let _ = std::fs::remove_dir_all(&directory);
    std::fs::create_dir_all(&directory).expect("a directory for the test");
    directory
}

#[test]
fn every_kind_comes_back_bit_by_bit() {
    let bytes = sample().to_bytes();
    let mut read = Checkpoint::from_bytes(&bytes).expect("undamaged");
    assert_eq!(read, sample());
    assert_eq!(bits(&read.take::<f64>("contact/stiffness").unwrap()), bits(&delicate()));
    let single: Vec<u32> =
        read.take::<f32>("particles/position").unwrap().iter().map(|x| x.to_bits()).collect();
    assert_eq!(single, [1.5f32, -0.0, f32::MIN_POSITIVE].map(f32::to_bits));
    assert_eq!(read.take::<u32>("pairs").unwrap(), [0, 7, u32::MAX]);
    let mut random = [0u64; 3];
    read.take_into("random", &mut random).unwrap();
    assert_eq!(random, [u64::MAX, 1, 0x0123_4567_89AB_CDEF]);
    let position = read.take::<Vec3>("position").unwrap();
    assert_eq!(position[0], Vec3::new(1.0, 2.0, 3.0));
    assert_eq!(position[1].x.to_bits(), (-0.0f64).to_bits());
    let deformation = read.take::<Mat3>("deformation").unwrap();
    assert_eq!((deformation[0][(0, 2)], deformation[0][(2, 0)]), (3.0, 7.0));
    assert!(read.take::<f64>("nothing").unwrap().is_empty());
    assert_eq!(read.take_text("scheme").unwrap(), "BDF2, κ adaptive");
    assert_eq!(read.take_one::<u64>("step").unwrap(), 12);
    read.finish().expect("everything was taken");
}

#[test]
fn the_layout_is_the_documented_one() {
    let mut checkpoint = Checkpoint::new();
    checkpoint.put("k", &[1.0f64]);
    let mut expected = b"MECHCKP\n".to_vec();
    expected.extend([1, 0, 0, 0]); // version
    expected.extend([1, 0, 0, 0]); // sections
    expected.extend([32 + 24 + 1 + 8 + 8, 0, 0, 0, 0, 0, 0, 0]);
    expected.extend(crc64(&expected).to_le_bytes());
    let head = [5, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]; // f64, a name of one byte, one element
    expected.extend(head);
    expected.extend(crc64(&head).to_le_bytes());
    let content = [b'k', 0, 0, 0, 0, 0, 0, 0xF0, 0x3F];
    expected.extend(content);
    expected.extend(crc64(&content).to_le_bytes());
    assert_eq!(checkpoint.to_bytes(), expected);
}

#[test]
fn the_bytes_do_not_depend_on_the_order_of_puts() {
    let mut other = Checkpoint::new();
    let mut source = sample();
    other.put_one("step", source.take_one::<u64>("step").unwrap());
    other.put("random", &source.take::<u64>("random").unwrap());
    other.put_text("scheme", &source.take_text("scheme").unwrap());
    let mut again = Checkpoint::new();
    again.put_text("scheme", "BDF2, κ adaptive");
    again.put("random", &[u64::MAX, 1, 0x0123_4567_89AB_CDEF]);
    again.put_one("step", 12u64);
    assert_eq!(other.to_bytes(), again.to_bytes());
}

#[test]
fn a_failed_take_names_the_culprit_and_takes_nothing() {
    let mut checkpoint = sample();
    let message = |error: CheckpointError| error.to_string();
    let missing = checkpoint.take::<f64>("velocity").unwrap_err();
    assert!(matches!(&missing, CheckpointError::Missing { name } if name == "velocity"));
    assert!(message(missing).contains("\"velocity\""));
    let wrong = checkpoint.take::<f32>("position").unwrap_err();
    assert!(matches!(wrong, CheckpointError::WrongKind { stored: Kind::Vec3, wanted: Kind::F32, .. }));
    assert_eq!(message(wrong), "section \"position\" of the checkpoint holds Vec3, not f32");
    let mut values = [7.0; 3];
    let short = checkpoint.take_into("contact/stiffness", &mut values).unwrap_err();
    assert!(matches!(short, CheckpointError::WrongLength { stored: 8, wanted: 3, .. }));
    assert_eq!(values, [7.0; 3]);
    let several = checkpoint.take_one::<u64>("random").unwrap_err();
    assert!(matches!(several, CheckpointError::WrongLength { stored: 3, wanted: 1, .. }));
    checkpoint.put("binary", &[b'a', 0xFF]);
    let binary = checkpoint.take_text("binary").unwrap_err();
    assert!(matches!(binary, CheckpointError::NotText { position: 1, .. }));
    let scheme = checkpoint.take_matching_text("scheme", "Newmark").unwrap_err();
    assert!(message(scheme).contains("says \"BDF2, κ adaptive\", but this scheme is \"Newmark\""));
    assert_eq!(checkpoint.take::<u8>("binary").unwrap(), [b'a', 0xFF]);
    assert_eq!(checkpoint, sample());
    checkpoint.take_matching_text("scheme", "BDF2, κ adaptive").unwrap();
    let left = checkpoint.finish().unwrap_err();
    assert!(matches!(left, CheckpointError::LeftOver { count: 8, ref name } if name == "contact/stiffness"));
}

#[test]
#[should_panic(expected = "two sections of a checkpoint are called \"step\"")]
fn two_sections_of_one_name_are_refused() {
    let mut checkpoint = Checkpoint::new();
    checkpoint.put_one("step", 1u64);
    checkpoint.put_one("step", 2u64);
}

#[test]
fn damage_is_located() {
    let bytes = sample().to_bytes();
    let text = bytes.windows(4).position(|window| window == b"BDF2").expect("the text is in the file");
    let mut damaged = bytes.clone();
    damaged[text] ^= 0x20;
    match Checkpoint::from_bytes(&damaged).unwrap_err() {
        CheckpointError::ChecksumMismatch { start, end, stored, computed } => {
            assert!((start..end).contains(&(text as u64)), "{start}..{end} holds byte {text}");
            assert!(end - start < 40, "only the damaged section is blamed");
            assert_ne!(stored, computed);
        }
        other => panic!("{other}"),
    }
}

#[test]
fn foreign_and_future_files_are_told_apart() {
    let from = |bytes: &[u8]| Checkpoint::from_bytes(bytes).unwrap_err();
    assert!(matches!(from(b"solid cube\nfacet normal"), CheckpointError::BadMagic));
    assert!(matches!(from(b"x"), CheckpointError::BadMagic));
    assert!(matches!(from(b""), CheckpointError::Truncated { expected: 8, actual: 0 }));
    assert!(matches!(from(b"MECHCKP\n"), CheckpointError::Truncated { expected: 12, actual: 8 }));
    let mut future = sample().to_bytes();
    future[8] = 2;
    let error = from(&future);
    assert!(matches!(error, CheckpointError::UnsupportedVersion { found: 2, supported: FORMAT_VERSION }));
    let mut longer = sample().to_bytes();
    longer.push(0);
    assert!(matches!(from(&longer), CheckpointError::TrailingBytes { .. }));
}

#[test]
fn every_truncation_is_noticed() {
    let bytes = sample().to_bytes();
    for length in 0..bytes.len() {
        let error = Checkpoint::from_bytes(&bytes[..length]).unwrap_err();
        assert!(matches!(error, CheckpointError::Truncated { .. }), "cut at {length}: {error}");
    }
}

#[test]
fn every_single_bit_flip_is_noticed() {
    let bytes = sample().to_bytes();
    let mut damaged = bytes.clone();
    for bit in 0..8 * bytes.len() {
        damaged[bit / 8] ^= 1 << (bit % 8);
        assert!(Checkpoint::from_bytes(&damaged).is_err(), "bit {bit} flipped and unnoticed");
        damaged[bit / 8] ^= 1 << (bit % 8);
    }
}

/// A small generator (Steele, Lea, Flood 2014, SplitMix64), so that the test is the same everywhere.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit as u64) as usize
    }
}

/// Writes the right checksum wherever one is expected, so that damage reaches what lies behind the checksums.
fn repair_checksums(bytes: &mut [u8]) {
    let number = |bytes: &[u8], at: usize| {
        bytes.get(at..at + 8).and_then(|word| word.try_into().ok()).map(u64::from_le_bytes)
    };
    let seal = |bytes: &mut [u8], start: usize, end: usize| {
        if end + 8 <= bytes.len() {
            let checksum = crc64(&bytes[start..end]);
            bytes[end..end + 8].copy_from_slice(&checksum.to_le_bytes());
        }
    };
    seal(bytes, 0, 24);
    let mut position = 32;
    while position + 24 <= bytes.len() {
        seal(bytes, position, position + 16);
        let codes = number(bytes, position).unwrap_or(0);
        let count = number(bytes, position + 8).unwrap_or(0);
        let size = Kind::from_code(codes as u32).map_or(0, Kind::element_size) as u64;
        let content = (codes >> 32).saturating_add(count.saturating_mul(size));
        let end = (position as u64 + 24).saturating_add(content);
        if end > bytes.len() as u64 {
            return;
        }
        seal(bytes, position + 24, end as usize);
        position = end as usize + 8;
    }
}

/// One to four accidents: flipped bits, foreign bytes, cuts, insertions, extreme lengths and counts.
fn damage(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..1 + random.below(4) {
        let at = random.below(bytes.len());
        match random.below(6) {
            0 => bytes[at] ^= 1 << random.below(8),
            1 => bytes[at] = random.next() as u8,
            2 => bytes.truncate(at.max(1)),
            3 => bytes.insert(at, random.next() as u8),
            4 => {
                let end = (at + 8).min(bytes.len());
                bytes[at..end].fill([0xFF, 0x7F, 0x00, 0x80][random.below(4)]);
            }
            _ => {
                let head = 32 + random.below(17);
                if head < bytes.len() {
                    bytes[head] = random.next() as u8;
                }
            }
        }
    }
}

/// Damages the sample and reads it; answers whether that gave a checkpoint. Every other time the damage is hidden
/// behind right checksums.
fn read_damaged(original: &[u8], round: u64, random: &mut Random) -> bool {
    let mut bytes = original.to_vec();
    damage(&mut bytes, random);
    if round % 2 == 0 {
        let length = (bytes.len() as u64).to_le_bytes();
        if bytes.len() >= 24 {
            bytes[16..24].copy_from_slice(&length);
        }
        repair_checksums(&mut bytes);
    }
    match Checkpoint::from_bytes(&bytes) {
        // Whatever is accepted is a proper checkpoint: it is written as it was read.
        Ok(checkpoint) => assert_eq!(checkpoint.to_bytes(), bytes, "round {round}"),
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return false;
        }
    }
    true
}

/// The same rounds every time; with `FUZZ_SECONDS` set, further ones for so long.
#[test]
fn arbitrary_damage_gives_a_checkpoint_or_an_error() {
    let original = sample().to_bytes();
    let mut random = Random(2026);
    let accepted = (0..60_000).filter(|&round| read_damaged(&original, round, &mut random)).count();
    assert!((1000..59_000).contains(&accepted), "both outcomes were reached: {accepted} of 60,000 accepted");
    let seconds = std::env::var("FUZZ_SECONDS").ok().and_then(|text| text.parse().ok()).unwrap_or(0.0);
    let start = std::time::Instant::now();
    let mut round = 60_000;
    while start.elapsed().as_secs_f64() < seconds {
        read_damaged(&original, round, &mut random);
        round += 1;
    }
}

#[test]
fn a_huge_count_is_refused_before_it_is_allocated() {
    let mut checkpoint = Checkpoint::new();
    checkpoint.put::<Mat3>("deformation", &[]);
    for count in [1u64, 1 << 40, u64::MAX / 72, u64::MAX] {
        let mut bytes = checkpoint.to_bytes();
        bytes[40..48].copy_from_slice(&count.to_le_bytes());
        repair_checksums(&mut bytes);
        let head = crc64(&bytes[32..48]).to_le_bytes();
        bytes[48..56].copy_from_slice(&head);
        let error = Checkpoint::from_bytes(&bytes).unwrap_err();
        assert!(matches!(error, CheckpointError::Truncated { .. }), "{count}: {error}");
    }
    let mut bytes = checkpoint.to_bytes();
    bytes[12..16].fill(0xFF); // four thousand million sections
    repair_checksums(&mut bytes);
    assert!(matches!(Checkpoint::from_bytes(&bytes), Err(CheckpointError::Truncated { .. })));
}

#[test]
fn unknown_kinds_and_bad_names_are_refused_behind_right_checksums() {
    let mut checkpoint = Checkpoint::new();
    checkpoint.put_text("ab", "x");
    let edit = |at: usize, value: u8| {
        let mut bytes = checkpoint.to_bytes();
        bytes[at] = value;
        let head = crc64(&bytes[32..48]).to_le_bytes();
        bytes[48..56].copy_from_slice(&head);
        repair_checksums(&mut bytes);
        Checkpoint::from_bytes(&bytes).unwrap_err()
    };
    assert!(matches!(edit(32, 99), CheckpointError::UnknownKind { offset: 32, code: 99 }));
    assert!(matches!(edit(36, 0), CheckpointError::BadName { offset: 32, .. }));
    assert!(matches!(edit(56, 0xFF), CheckpointError::BadName { offset: 32, .. }));
    let mut twice = Checkpoint::new();
    twice.put_text("aa", "x");
    twice.put_text("ab", "y");
    let mut bytes = twice.to_bytes();
    let second = bytes.windows(2).position(|window| window == b"ab").expect("the second name");
    bytes[second + 1] = b'a';
    repair_checksums(&mut bytes);
    assert!(matches!(Checkpoint::from_bytes(&bytes), Err(CheckpointError::BadName { .. })));
}

#[test]
fn a_file_is_replaced_whole_and_leaves_nothing_behind() {
    let directory = directory("replace");
    let path = directory.join("run.checkpoint");
    Checkpoint::new().write(&path).expect("a writable directory");
    sample().write(&path).expect("a writable directory");
    assert_eq!(Checkpoint::read(&path).expect("just written"), sample());
    let names: Vec<_> =
        std::fs::read_dir(&directory).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names, ["run.checkpoint"]);
}

#[test]
fn a_failed_write_keeps_the_old_file_and_cleans_up() {
    let directory = directory("failed");
    // A directory that is not empty cannot be replaced by a file: the rename is what fails.
    let taken = directory.join("taken");
    std::fs::create_dir_all(taken.join("inner")).unwrap();
    let error = sample().write(&taken).unwrap_err();
    assert!(
        matches!(error, CheckpointError::Io { action: "replace", ref path, .. } if *path == taken),
        "{error}"
    );
    assert!(taken.join("inner").is_dir());
    assert_eq!(std::fs::read_dir(&directory).unwrap().count(), 1, "the temporary file is gone");
}

#[test]
fn io_errors_carry_the_path() {
    let directory = directory("missing");
    let missing = directory.join("no such folder").join("x.checkpoint");
    let error = sample().write(&missing).unwrap_err();
    assert!(matches!(error, CheckpointError::Io { action: "create", .. }));
    assert!(error.to_string().contains("no such folder"), "{error}");
    let error = Checkpoint::read(&missing).unwrap_err();
    assert!(matches!(error, CheckpointError::Io { action: "read", ref path, .. } if *path == missing));
    assert!(matches!(sample().write("/"), Err(CheckpointError::Io { .. })));
}

#[test]
fn writers_of_one_path_do_not_mix() {
    let directory = directory("race");
    let path = directory.join("shared.checkpoint");
    let of = |writer: u64| {
        let mut checkpoint = Checkpoint::new();
        checkpoint.put("content", &vec![writer; 5000]);
        checkpoint
    };
    std::thread::scope(|scope| {
        for writer in 0..4 {
            let path = &path;
            scope.spawn(move || {
                for _ in 0..10 {
                    of(writer).write(path).expect("a writable directory");
                    let content =
                        Checkpoint::read(path).expect("always whole").take::<u64>("content").unwrap();
                    assert!(content.iter().all(|value| *value == content[0]));
                }
            });
        }
    });
    assert_eq!(std::fs::read_dir(&directory).unwrap().count(), 1);
}

fn moving_state() -> State {
    let mut state = State::at_rest(vec![Vec3::new(0.1, -0.0, 3.0), Vec3::new(4.0, 5.0, 6.0)]);
    state.time = 0.25;
    state.step = 17;
    state.velocity[1] = Vec3::new(0.0, 0.0, -9.81);
    state.set_history("acceleration", vec![Vec3::new(1.0, 2.0, 3.0); 2]);
    state.set_history("earlier/position", vec![Vec3::new(-1.0, 0.0, 1.0); 2]);
    state
}

#[test]
fn a_state_survives_a_checkpoint() {
    let mut checkpoint = Checkpoint::new();
    moving_state().save(&mut checkpoint, "left");
    State::at_rest(vec![]).save(&mut checkpoint, "right");
    let mut read = Checkpoint::from_bytes(&checkpoint.to_bytes()).expect("undamaged");
    let left = State::load(&mut read, "left").expect("saved above");
    assert_eq!(left, moving_state());
    assert_eq!(left.hash(), moving_state().hash());
    assert_eq!(left.history("acceleration"), Some([Vec3::new(1.0, 2.0, 3.0); 2].as_slice()));
    assert_eq!(left.history("jerk"), None);
    assert_eq!(State::load(&mut read, "right").expect("saved above").point_count(), 0);
    read.finish().expect("two states and nothing else");
}

#[test]
fn a_state_that_does_not_fit_is_refused_and_left_alone() {
    let mut checkpoint = Checkpoint::new();
    moving_state().save(&mut checkpoint, "body");
    checkpoint.take::<Vec3>("body/history/acceleration").unwrap();
    checkpoint.put("body/history/acceleration", &[Vec3::zeros()]);
    let before = checkpoint.clone();
    let error = State::load(&mut checkpoint, "body").unwrap_err();
    assert!(matches!(error, CheckpointError::WrongLength { stored: 1, wanted: 2, .. }), "{error}");
    assert_eq!(checkpoint, before);
    assert!(matches!(State::load(&mut checkpoint, "cloth"), Err(CheckpointError::Missing { .. })));
}

#[test]
fn the_hash_sees_every_part_of_a_state() {
    let changes: [fn(&mut State); 7] = [
        |state| state.time += 1e-300,
        |state| state.time = f64::from_bits(state.time.to_bits() + 1),
        |state| state.step += 1,
        |state| state.position[0].y = 0.0, // was −0
        |state| state.position.swap(0, 1),
        |state| state.velocity[0].x = 5e-324,
        |state| state.clear_history(),
    ];
    let original = moving_state();
    let mut unchanged = 0;
    for (k, change) in changes.iter().enumerate() {
        let mut state = original.clone();
        change(&mut state);
        if state.time == original.time && k == 0 {
            unchanged += 1; // 1e-300 is below the resolution of 0.25: the same bits, the same hash
            assert_eq!(state.hash(), original.hash());
        } else {
            assert_ne!(state.hash(), original.hash(), "change {k}");
        }
    }
    assert_eq!(unchanged, 1);
}

#[test]
fn the_hash_is_the_documented_checksum() {
    let mut hash = StateHash::new();
    assert_eq!(hash.value(), crc64(b""));
    hash.add("x", &[1.0, -0.0, f64::from_bits(0xFFF8_0000_0000_0001)]);
    hash.add_integers("n", &[3]);
    let mut bytes = Vec::new();
    for part in [&1u64.to_le_bytes()[..], b"x", &3u64.to_le_bytes()] {
        bytes.extend_from_slice(part);
    }
    for word in [0x3FF0_0000_0000_0000u64, 0x8000_0000_0000_0000, 0x7FF8_0000_0000_0000] {
        bytes.extend_from_slice(&word.to_le_bytes());
    }
    for part in [&1u64.to_le_bytes()[..], b"n", &1u64.to_le_bytes(), &3u64.to_le_bytes()] {
        bytes.extend_from_slice(part);
    }
    assert_eq!(hash.value(), crc64(&bytes));
}

#[test]
fn the_hash_keeps_arrays_apart() {
    let of = |arrays: &[(&str, &[f64])]| {
        let mut hash = StateHash::new();
        arrays.iter().for_each(|(name, values)| hash.add(name, values));
        hash.value()
    };
    let all = [
        of(&[("a", &[1.0, 2.0])]),
        of(&[("a", &[2.0, 1.0])]),
        of(&[("b", &[1.0, 2.0])]),
        of(&[("a", &[1.0]), ("a", &[2.0])]),
        of(&[("a", &[1.0, 2.0]), ("a", &[])]),
        of(&[("a", &[]), ("a", &[1.0, 2.0])]),
        of(&[]),
    ];
    for i in 0..all.len() {
        for j in 0..i {
            assert_ne!(all[i], all[j], "{i} and {j}");
        }
    }
    assert_eq!(of(&[("a", &[f64::NAN])]), of(&[("a", &[-f64::NAN])]));
    let mut vectors = StateHash::new();
    vectors.add_vectors("v", &[Vec3::new(1.0, 2.0, 3.0)]);
    assert_eq!(vectors.value(), of(&[("v", &[1.0, 2.0, 3.0])]));
}
