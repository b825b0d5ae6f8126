//! The functions of the stages refuse what is out of range, with numbers. That they are core's stages is held by the directed
//! vectors (`host-tests/tests/c_stages.rs`).

use core::ptr::{null, null_mut};

use slicecast_ffi::*;

fn error() -> SlicecastError {
    SlicecastError {
        code: 99,
        argument: 99,
        needed: 99,
        given: 99,
        row: 99,
        column: 99,
    }
}

/// What a refusal tells: code, argument, needed, given.
fn told(code: i32, error: SlicecastError) -> (i32, u32, i64, i64) {
    assert_eq!(code, error.code);
    (code, error.argument, error.needed, error.given)
}

#[test]
fn numbers_out_of_range_are_refused_with_the_end_that_they_pass() {
    let mut error = error();
    let (mut position, mut sample, mut kept) = (7, 7, 7);
    // SAFETY: good pointers.
    unsafe {
        let locate = |start, step, plane, position: &mut i32, error: &mut SlicecastError| {
            let code = slicecast_stage_locate(start, step, plane, position, error);
            told(code, *error)
        };
        let range = SLICECAST_RANGE;
        assert_eq!(
            locate(0, (1 << 32) + 1, 0, &mut position, &mut error),
            (range, 2, 1 << 32, (1 << 32) + 1)
        );
        assert_eq!(
            locate(i64::MIN, 0, 0, &mut position, &mut error),
            (range, 1, -(8192 << 32), i64::MIN)
        );
        assert_eq!(locate(0, 0, 32769, &mut position, &mut error), (range, 3, 32768, 32769));
        assert_eq!(position, 7, "nothing is written by a refusal");
        assert_eq!(
            locate(-(1 << 32), 3 << 15, 1, &mut position, &mut error),
            (SLICECAST_OK, 0, 0, 0)
        );
        assert_eq!(position, -65534);

        let weights = [0_u16; 3];
        let voxels = [0, 0, 0, 8191, 0, 0, 0, 0_i16];
        let code = slicecast_stage_interpolate(1, voxels.as_ptr(), weights.as_ptr(), &mut sample, &mut error);
        assert_eq!(told(code, error), (range, 2, 8190, 8191));
        let code = slicecast_stage_interpolate(3, [0; 8].as_ptr(), weights.as_ptr(), &mut sample, &mut error);
        assert_eq!(told(code, error), (range, 1, 2, 3));

        let code = slicecast_stage_project(2, 0, &mut kept, &mut error);
        assert_eq!(told(code, error), (range, 1, 1, 2));
        let code = slicecast_stage_project(0, -1, &mut kept, &mut error);
        assert_eq!(told(code, error), (range, 2, 0, -1));
    }
}

#[test]
fn pixels_that_hold_more_light_than_there_is_are_refused() {
    let mut error = error();
    let composite = |order, opacity, colour: [u32; 3], mut pixel: [u32; 4], error: &mut SlicecastError| {
        // SAFETY: good pointers.
        let code =
            unsafe { slicecast_stage_composite(1, order, 0, 1, opacity, colour.as_ptr(), pixel.as_mut_ptr(), error) };
        (told(code, *error), pixel)
    };
    let range = SLICECAST_RANGE;
    let full = [0, 2, 0, 65534];
    assert_eq!(composite(0, 0, [0; 3], full, &mut error), ((range, 7, 1, 2), full));
    assert_eq!(composite(1, 0, [0; 3], full, &mut error).0.0, SLICECAST_OK);
    assert_eq!(
        composite(0, (1 << 31) + 1, [0; 3], [0; 4], &mut error).0,
        (range, 5, 1 << 31, (1 << 31) + 1)
    );
    assert_eq!(
        composite(0, 0, [0, 0, 32769], [0; 4], &mut error).0,
        (range, 6, 32768, 32769)
    );
    assert_eq!(
        composite(0, 0, [0; 3], [0, 0, 0, 65536], &mut error).0,
        (range, 7, 65535, 65536)
    );
}

#[test]
fn null_pointers_are_named_by_their_places() {
    let mut error = error();
    let (numbers, halves, table) = ([0_i32; 5], [1_u16; 3], [0_u32; 4096]);
    let (mut out, mut opacity) = ([0_i32; 3], 0);
    // SAFETY: good pointers, and null ones, which the functions promise to refuse.
    unsafe {
        let code = slicecast_stage_gradient(null(), halves.as_ptr(), out.as_mut_ptr(), &mut error);
        assert_eq!((code, error.argument), (SLICECAST_NULL, 1));
        let code = slicecast_stage_gradient(numbers.as_ptr(), halves.as_ptr(), null_mut(), &mut error);
        assert_eq!((code, error.argument), (SLICECAST_NULL, 3));
        // The low bytes are asked for where the code has them.
        let mut classify = |code, error: &mut SlicecastError| {
            let mut colour = [0_u32; 3];
            let (entries, colour) = (table.as_ptr(), colour.as_mut_ptr());
            slicecast_stage_classify(1, code, 1, 0, entries, null(), null(), &mut opacity, colour, error)
        };
        assert_eq!(classify(0, &mut error), SLICECAST_OK);
        assert_eq!((classify(1, &mut error), error.argument), (SLICECAST_NULL, 6));
        let code = slicecast_stage_normalise(numbers.as_ptr(), out.as_mut_ptr(), null_mut(), &mut error);
        assert_eq!((code, error.argument), (SLICECAST_NULL, 3));
    }
}
