//! A table of bits over two lists, most parts of which are empty or full.

/// Members of a list in one block.
const BLOCK: usize = 32;
/// Pairs of blocks without a bit, and full of bits; larger numbers are those of tiles, counted from
/// `FIRST`.
const NOTHING: u32 = 0;
const ALL: u32 = 1;
const FIRST: u32 = 2;

/// Bits of a block of rows and a block of columns: a number per row.
type Tile = [u32; BLOCK];

/// One bit per row and column. Rows and columns are cut into blocks in the order of their places;
/// only pairs of blocks that are neither empty nor full keep their bits. What is asked for together
/// should lie together.
#[derive(Clone, Debug, Default)]
pub(crate) struct BitTable {
    /// Places of the rows, and of the columns, in their lists.
    rows: Vec<u16>,
    columns: Vec<u16>,
    /// Blocks of columns.
    blocks: usize,
    /// Per block of rows and block of columns: what they hold, or the number of their tile.
    held: Vec<u32>,
    tiles: Vec<Tile>,
}

impl BitTable {
    /// Asks `is_set(row, column)` for every bit. `rows` and `columns` hold their places: each of
    /// `0..len` once.
    pub fn new(rows: Vec<u16>, columns: Vec<u16>, is_set: impl Fn(usize, usize) -> bool) -> Self {
        let [of_row, of_column] = [&rows, &columns].map(|places| blocks(places));
        let mut table = Self { blocks: of_column.len(), ..Self::default() };
        for rows in &of_row {
            for columns in &of_column {
                let mut tile = [0; BLOCK];
                let (mut any, mut all) = (false, true);
                for &(row, lane) in rows {
                    for &(column, bit) in columns {
                        let is_set = is_set(row, column);
                        tile[lane] |= u32::from(is_set) << bit;
                        (any, all) = (any | is_set, all & is_set);
                    }
                }
                table.held.push(match (any, all) {
                    (false, _) => NOTHING,
                    (true, true) => ALL,
                    (true, false) => {
                        table.tiles.push(tile);
                        table.tiles.len() as u32 - 1 + FIRST
                    }
                });
            }
        }
        Self { rows, columns, ..table }
    }

    /// Symmetric table of a list with itself; asks only for rows up to the column.
    pub fn symmetric(places: Vec<u16>, is_set: impl Fn(usize, usize) -> bool) -> Self {
        let count = places.len();
        let mut known = vec![false; count * count];
        for (i, j) in (0..count).flat_map(|i| (i..count).map(move |j| (i, j))) {
            let is_set = is_set(i, j);
            (known[i * count + j], known[j * count + i]) = (is_set, is_set);
        }
        Self::new(places.clone(), places, |i, j| known[i * count + j])
    }

    /// True of a table without entries.
    pub fn is_empty(&self) -> bool {
        self.held.is_empty()
    }

    /// The bit of a row and a column.
    #[inline]
    pub fn is_set(&self, row: u32, column: u32) -> bool {
        let (row, column) = (self.rows[row as usize], self.columns[column as usize]);
        let [i, j] = [row, column].map(|place| usize::from(place) / BLOCK);
        match self.held[i * self.blocks + j] {
            NOTHING => false,
            ALL => true,
            tile => {
                let bits = self.tiles[(tile - FIRST) as usize][usize::from(row) % BLOCK];
                bits >> (usize::from(column) % BLOCK) & 1 == 1
            }
        }
    }
}

/// The members of each block, with their places in it.
fn blocks(places: &[u16]) -> Vec<Vec<(usize, usize)>> {
    let mut blocks = vec![Vec::new(); places.len().div_ceil(BLOCK)];
    for (member, place) in places.iter().enumerate() {
        let place = usize::from(*place);
        blocks[place / BLOCK].push((member, place % BLOCK));
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Full, empty and mixed blocks, in lists whose members come in any order.
    #[test]
    fn every_bit_is_what_it_was_filled_with() {
        for (rows, columns) in [(1, 1), (23, 40), (96, 96), (100, 161)] {
            let places = |n: usize| (0..n).map(|i| (n - 1 - i) as u16).collect::<Vec<_>>();
            let is_set = |r: usize, c: usize| match ((rows - 1 - r) / 32, (columns - 1 - c) / 32) {
                (0, _) => true,
                (1, 2) | (3, 3) => (r + c).is_multiple_of(3),
                (i, j) => i == j,
            };
            let table = BitTable::new(places(rows), places(columns), is_set);
            assert!(!table.is_empty() && BitTable::default().is_empty());
            for (r, c) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
                assert_eq!(table.is_set(r as u32, c as u32), is_set(r, c), "{r} {c}");
            }
            let mixed = usize::from(rows > 32 && columns > 64) + usize::from(rows > 96);
            assert_eq!(table.tiles.len(), mixed, "{rows} {columns}");
            let ordered = |i: usize, j: usize| {
                assert!(i <= j);
                is_set(i, j)
            };
            let symmetric = BitTable::symmetric(places(rows), ordered);
            for (i, j) in (0..rows).flat_map(|i| (0..rows).map(move |j| (i, j))) {
                let expected = is_set(i.min(j), i.max(j));
                assert_eq!(symmetric.is_set(i as u32, j as u32), expected, "{i} {j}");
            }
        }
    }
}
