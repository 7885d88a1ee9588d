//! A small HDF5 file: columns of numbers and words, with text attributes, in groups.
//!
//! Written by hand, so that the program needs no libhdf5, whose libraries (36 of them on Debian) would be loaded at every
//! start; the tests read the files back with it. Layout after the HDF Group's "HDF5 File Format Specification Version 3.0":
//! superblock 2, object headers 2 with compact links, contiguous data, words of any length in global heaps. No time stamps:
//! the same columns give the same bytes.

/// One dataset of one dimension.
pub struct Column {
    /// Its name; no `/`.
    pub name: String,
    /// Its values.
    pub values: Values,
    /// Text attributes, by name.
    pub attributes: Vec<(&'static str, String)>,
}

/// What a column holds.
pub enum Values {
    /// IEEE 754, 8 bytes.
    Numbers(Vec<f64>),
    /// IEEE 754, 4 bytes: rows of so many, or single ones where it is 1.
    Singles(Vec<f32>, usize),
    /// Signed, 8 bytes: rows of so many, or single ones where it is 1.
    Integers(Vec<i64>, usize),
    /// UTF-8 of any length.
    Words(Vec<String>),
}

impl Values {
    /// Numbers along each axis.
    fn shape(&self) -> Vec<u64> {
        let rows = |length: usize, width: usize| match width {
            1 => vec![length as u64],
            _ => vec![(length / width) as u64, width as u64],
        };
        match self {
            Values::Numbers(x) => rows(x.len(), 1),
            Values::Singles(x, width) => rows(x.len(), *width),
            Values::Integers(x, width) => rows(x.len(), *width),
            Values::Words(x) => rows(x.len(), 1),
        }
    }

    fn kind(&self) -> Vec<u8> {
        match self {
            Values::Numbers(_) => float(8),
            Values::Singles(..) => float(4),
            Values::Integers(..) => integer(),
            Values::Words(_) => text(),
        }
    }
}

/// A group: datasets, groups in it, and attributes of its own.
pub struct Group {
    /// Its name; the root's is not used.
    pub name: &'static str,
    /// Its attributes.
    pub marks: Vec<(&'static str, Mark)>,
    /// Its datasets.
    pub columns: Vec<Column>,
    /// Its groups.
    pub groups: Vec<Group>,
}

/// An attribute of a group.
pub enum Mark {
    /// ASCII of fixed length.
    Word(&'static str),
    /// One number.
    Integer(i64),
    /// Some numbers.
    Integers(Vec<i64>),
}

/// "No address."
const NOWHERE: u64 = u64::MAX;
const SUPERBLOCK: usize = 48;

/// The bytes of a file with these columns in its root group.
pub fn encode(columns: Vec<Column>) -> Vec<u8> {
    encode_tree(&Group { name: "", marks: Vec::new(), columns, groups: Vec::new() })
}

/// The bytes of a file whose root group is `root`.
pub fn encode_tree(root: &Group) -> Vec<u8> {
    let mut file = vec![0; SUPERBLOCK];
    let mut columns = Vec::new();
    root.collect(&mut columns);
    let mut words = Heaps::write(&mut file, &columns).into_iter();
    let address = root.write(&mut file, &mut words);
    superblock(&mut file, address);
    file
}

impl Group {
    /// Its columns and those of its groups, in the order in which they are written.
    fn collect<'a>(&'a self, all: &mut Vec<&'a Column>) {
        all.extend(&self.columns);
        self.groups.iter().for_each(|group| group.collect(all));
    }

    /// Writes all that is in it, then itself; returns where it is.
    fn write(&self, file: &mut Vec<u8>, words: &mut std::vec::IntoIter<Word>) -> u64 {
        let mut links = Vec::new();
        for column in &self.columns {
            links.push((column.name.as_str(), column.write(file, words)));
        }
        for group in &self.groups {
            links.push((group.name, group.write(file, words)));
        }
        let address = file.len() as u64;
        file.extend(group(&links, &self.marks));
        align(file);
        address
    }
}

impl Column {
    /// Writes its data and its header; returns where the header is.
    fn write(&self, file: &mut Vec<u8>, words: &mut std::vec::IntoIter<Word>) -> u64 {
        let data = file.len() as u64;
        match &self.values {
            Values::Numbers(x) => x.iter().for_each(|x| file.extend(x.to_le_bytes())),
            Values::Singles(x, _) => x.iter().for_each(|x| file.extend(x.to_le_bytes())),
            Values::Integers(x, _) => x.iter().for_each(|x| file.extend(x.to_le_bytes())),
            Values::Words(texts) => words.by_ref().take(texts.len()).for_each(|word| file.extend(word)),
        }
        let bytes = file.len() as u64 - data;
        align(file);
        let address = file.len() as u64;
        let attributes = self.attributes.iter().map(|(name, _)| (*name, words.next().expect("one word an attribute")));
        let header = dataset(&self.values, if bytes == 0 { NOWHERE } else { data }, bytes, attributes);
        file.extend(header);
        align(file);
        address
    }
}

fn align(file: &mut Vec<u8>) {
    file.resize(file.len().next_multiple_of(8), 0);
}

/// Section II.A: where the root group is, and where the file ends.
fn superblock(file: &mut [u8], root: u64) {
    let end = file.len() as u64;
    let mut head = b"\x89HDF\r\n\x1a\n\x02\x08\x08\x00".to_vec();
    for address in [0, NOWHERE, end, root] {
        head.extend(address.to_le_bytes());
    }
    head.extend(lookup3(&head).to_le_bytes());
    file[..SUPERBLOCK].copy_from_slice(&head);
}

/// Section IV.A.1.b: an object header of messages `(type, bytes)`.
fn header(messages: &[(u8, Vec<u8>)]) -> Vec<u8> {
    let size: usize = messages.iter().map(|(_, bytes)| 4 + bytes.len()).sum();
    let mut out = b"OHDR\x02\x02".to_vec();
    out.extend((size as u32).to_le_bytes());
    for (kind, bytes) in messages {
        out.push(*kind);
        out.extend((bytes.len() as u16).to_le_bytes());
        out.push(0);
        out.extend(bytes);
    }
    out.extend(lookup3(&out).to_le_bytes());
    out
}

/// A group of hard links: link info (2), group info (10) and a link message (6) each, then attributes (12).
fn group(links: &[(&str, u64)], marks: &[(&str, Mark)]) -> Vec<u8> {
    let info = [&[0, 0][..], &NOWHERE.to_le_bytes(), &NOWHERE.to_le_bytes()].concat();
    let mut messages = vec![(2, info), (10, vec![0, 0])];
    for (name, address) in links {
        // Version 1; flags: two bytes for the name's length, character set given; UTF-8.
        let mut link = vec![1, 0x11, 1];
        link.extend((name.len() as u16).to_le_bytes());
        link.extend(name.as_bytes());
        link.extend(address.to_le_bytes());
        messages.push((6, link));
    }
    messages.extend(marks.iter().map(|(name, mark)| {
        let numbers = |x: &[i64]| x.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let bytes = match mark {
            Mark::Word(word) => attribute(name, &ascii(word.len()), &SCALAR, word.as_bytes()),
            Mark::Integer(x) => attribute(name, &integer(), &SCALAR, &numbers(&[*x])),
            Mark::Integers(x) => attribute(name, &integer(), &space(&[x.len() as u64]), &numbers(x)),
        };
        (12, bytes)
    }));
    header(&messages)
}

/// A dataset: dataspace (1), datatype (3), fill value (5), layout (8), attributes (12).
fn dataset<'a>(values: &Values, data: u64, bytes: u64, attributes: impl Iterator<Item = (&'a str, Word)>) -> Vec<u8> {
    // Contiguous, version 3.
    let layout = [&[3, 1][..], &data.to_le_bytes(), &bytes.to_le_bytes()].concat();
    let mut messages = vec![(1, space(&values.shape())), (3, values.kind()), (5, vec![3, 0x0a]), (8, layout)];
    messages.extend(attributes.map(|(name, word)| (12, attribute(name, &text(), &SCALAR, &word))));
    header(&messages)
}

/// A simple dataspace, version 2.
fn space(shape: &[u64]) -> Vec<u8> {
    let mut out = vec![2, shape.len() as u8, 0, 1];
    shape.iter().for_each(|n| out.extend(n.to_le_bytes()));
    out
}

/// The dataspace of one value.
const SCALAR: [u8; 4] = [2, 0, 0, 0];

/// An attribute, version 3.
fn attribute(name: &str, kind: &[u8], space: &[u8], value: &[u8]) -> Vec<u8> {
    let mut out = vec![3, 0];
    for size in [name.len() + 1, kind.len(), space.len()] {
        out.extend((size as u16).to_le_bytes());
    }
    out.push(1);
    out.extend(name.as_bytes());
    out.push(0);
    out.extend(kind);
    out.extend(space);
    out.extend(value);
    out
}

/// Datatype of class 1, version 1: f64 or f32 by its size, little-endian.
fn float(size: u32) -> Vec<u8> {
    let (exponent, mantissa, bias) = if size == 8 { ((52, 11), (0, 52), 1023_u32) } else { ((23, 8), (0, 23), 127) };
    let precision = 8 * size as u16;
    let mut out = vec![0x11, 0x20, precision as u8 - 1, 0];
    out.extend(size.to_le_bytes());
    out.extend(0_u16.to_le_bytes());
    out.extend(precision.to_le_bytes());
    out.extend([exponent.0, exponent.1, mantissa.0, mantissa.1]);
    out.extend(bias.to_le_bytes());
    out
}

/// Datatype of class 0, version 1: i64, little-endian.
fn integer() -> Vec<u8> {
    let mut out = vec![0x10, 0x08, 0, 0];
    out.extend(8_u32.to_le_bytes());
    out.extend(0_u16.to_le_bytes());
    out.extend(64_u16.to_le_bytes());
    out
}

/// Datatype of class 3, version 1: ASCII of `length`, filled up with zeros.
fn ascii(length: usize) -> Vec<u8> {
    let mut out = vec![0x13, 1, 0, 0];
    out.extend((length as u32).to_le_bytes());
    out
}

/// Datatype of class 9, version 1: text of any length, UTF-8, made of unsigned bytes.
fn text() -> Vec<u8> {
    let mut out = vec![0x19, 1, 1, 0];
    out.extend((size_of::<Word>() as u32).to_le_bytes());
    out.extend([0x10, 0, 0, 0]);
    out.extend(1_u32.to_le_bytes());
    out.extend([0, 0, 8, 0]);
    out
}

/// What stands for a text: its length, the address of its heap, its number there.
type Word = [u8; 16];

/// Section III.E: the global heaps, which hold the texts.
struct Heaps;

impl Heaps {
    /// Texts a heap: its numbers are 16 bits wide.
    const TEXTS: usize = 4096;
    /// No heap is smaller [B].
    const LEAST: usize = 4096;

    /// Writes the texts of all columns, values before attributes; returns what stands for each.
    fn write(file: &mut Vec<u8>, columns: &[&Column]) -> Vec<Word> {
        let mut texts: Vec<&str> = Vec::new();
        for column in columns {
            if let Values::Words(values) = &column.values {
                texts.extend(values.iter().map(String::as_str));
            }
            texts.extend(column.attributes.iter().map(|(_, text)| text.as_str()));
        }
        texts.chunks(Heaps::TEXTS).flat_map(|texts| Heaps::one(file, texts)).collect()
    }

    fn one(file: &mut Vec<u8>, texts: &[&str]) -> Vec<Word> {
        let (address, mut body, mut words) = (file.len() as u64, Vec::new(), Vec::new());
        for (i, text) in texts.iter().enumerate() {
            let number = i as u16 + 1;
            let mut word = [0; 16];
            // No text is no address.
            if !text.is_empty() {
                word[..4].copy_from_slice(&(text.len() as u32).to_le_bytes());
                word[4..12].copy_from_slice(&address.to_le_bytes());
                word[12..].copy_from_slice(&u32::from(number).to_le_bytes());
                for part in [&number.to_le_bytes()[..], &[1, 0, 0, 0, 0, 0], &(text.len() as u64).to_le_bytes()] {
                    body.extend(part);
                }
                body.extend(text.as_bytes());
                align(&mut body);
            }
            words.push(word);
        }
        // The rest is object 0, free: its head counts.
        let size = (16 + body.len() + 16).max(Heaps::LEAST);
        let free = size - 16 - body.len();
        file.extend(b"GCOL\x01\0\0\0");
        file.extend((size as u64).to_le_bytes());
        file.extend(body);
        let rest = file.len();
        file.extend([0; 8]);
        file.extend((free as u64).to_le_bytes());
        file.resize(rest + free, 0);
        words
    }
}

/// The checksum of HDF5's metadata: Bob Jenkins' `lookup3` (2006), `hashlittle` with initial value 0.
fn lookup3(bytes: &[u8]) -> u32 {
    let start = 0xdead_beef_u32.wrapping_add(bytes.len() as u32);
    let mut s = [start; 3];
    let words = |block: &[u8]| {
        let mut padded = [0; 12];
        padded[..block.len()].copy_from_slice(block);
        [0, 4, 8].map(|at| u32::from_le_bytes([padded[at], padded[at + 1], padded[at + 2], padded[at + 3]]))
    };
    let add = |s: &mut [u32; 3], block: &[u8]| {
        s.iter_mut().zip(words(block)).for_each(|(s, word)| *s = s.wrapping_add(word));
    };
    let mut rest = bytes;
    while rest.len() > 12 {
        let (block, after) = rest.split_at(12);
        add(&mut s, block);
        // mix: each of the three in turn, minus the one before it, which is turned and added on.
        for (k, turn) in [4, 6, 8, 16, 19, 4].into_iter().enumerate() {
            let (x, y, z) = (k % 3, (k + 1) % 3, (k + 2) % 3);
            s[x] = s[x].wrapping_sub(s[z]) ^ s[z].rotate_left(turn);
            s[z] = s[z].wrapping_add(s[y]);
        }
        rest = after;
    }
    if rest.is_empty() {
        return s[2];
    }
    add(&mut s, rest);
    // final
    for (k, turn) in [14, 11, 25, 16, 4, 14, 24].into_iter().enumerate() {
        let (x, y) = ((k + 2) % 3, (k + 1) % 3);
        s[x] = (s[x] ^ s[y]).wrapping_sub(s[y].rotate_left(turn));
    }
    s[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The values that the author's test program gives (lookup3.c, driver 5).
    #[test]
    fn checksums_are_those_of_lookup3() {
        assert_eq!(lookup3(b""), 0xdead_beef);
        assert_eq!(lookup3(b"Four score and seven years ago"), 0x1777_0551);
    }
}
