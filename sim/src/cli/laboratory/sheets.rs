//! Pictures beside and below each other.

use slicecast_engine::image::Rgb;

fn black(size: [u32; 2]) -> Rgb {
    let [width, height] = size;
    let bytes = vec![0; 3 * width as usize * height as usize];
    Rgb { size, bytes }
}

/// Pictures side by side on black, upper edges in line.
pub fn in_a_row(pictures: &[Rgb]) -> Rgb {
    const GAP: u32 = 4;
    let height = pictures.iter().map(|picture| picture.size[1]).max().unwrap_or(0);
    let widths = pictures.iter().map(|picture| picture.size[0] + GAP).sum::<u32>();
    let mut sheet = black([widths.saturating_sub(GAP), height]);
    let wide = 3 * sheet.size[0] as usize;
    let mut left = 0;
    for Rgb { size, bytes } in pictures {
        let len = 3 * size[0] as usize;
        let rows = bytes.chunks_exact(len.max(1));
        for (out, row) in sheet.bytes.chunks_exact_mut(wide.max(1)).zip(rows) {
            out[left..left + len].copy_from_slice(row);
        }
        left += len + 3 * GAP as usize;
    }
    sheet
}

/// Pictures below each other on black, left edges in line.
pub fn in_a_column(pictures: &[Rgb]) -> Rgb {
    let width = pictures.iter().map(|picture| picture.size[0]).max().unwrap_or(0);
    let height = pictures.iter().map(|picture| picture.size[1]).sum();
    let mut sheet = black([width, height]);
    let wide = 3 * width as usize;
    let mut rows = sheet.bytes.chunks_exact_mut(wide.max(1));
    for Rgb { size, bytes } in pictures {
        let len = 3 * size[0] as usize;
        for (row, out) in bytes.chunks_exact(len.max(1)).zip(&mut rows) {
            out[..len].copy_from_slice(row);
        }
    }
    sheet
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(size: [u32; 2], grey: u8) -> Rgb {
        Rgb {
            bytes: vec![grey; black(size).bytes.len()],
            size,
        }
    }

    #[test]
    fn pictures_stand_side_by_side() {
        let row = in_a_row(&[of([2, 3], 10), of([1, 1], 20)]);
        assert_eq!(row.size, [7, 3]);
        let pixels: Vec<u8> = row.bytes.chunks(3).map(|pixel| pixel[0]).collect();
        assert_eq!(pixels[..7], [10, 10, 0, 0, 0, 0, 20]);
        assert_eq!(pixels[14..], [10, 10, 0, 0, 0, 0, 0]);
        assert!(in_a_row(&[]).bytes.is_empty());
    }

    #[test]
    fn pictures_stand_below_each_other() {
        let column = in_a_column(&[of([1, 2], 10), of([2, 1], 20)]);
        let pixels: Vec<u8> = column.bytes.chunks(3).map(|pixel| pixel[0]).collect();
        assert_eq!((column.size, &pixels[..]), ([2, 3], &[10, 0, 10, 0, 20, 20][..]));
    }
}
