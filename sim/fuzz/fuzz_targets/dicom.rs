#![no_main]
//! A series of up to eight files, separated by `<next>`: a volume or an error of one line.

use libfuzzer_sys::fuzz_target;
use slicecast_volume::choice::Choice;
use slicecast_volume::dicom;
use slicecast_volume::mapping::Window;
use slicecast_volume::open;

fuzz_target!(|bytes: &[u8]| {
    let mut files = Vec::new();
    let mut rest = bytes;
    while files.len() < 8 {
        let end = rest.windows(6).position(|window| window == b"<next>");
        let (file, after) = end.map_or((rest, &[][..]), |end| (&rest[..end], &rest[end + 6..]));
        files.push((format!("{}.dcm", files.len()), file.to_vec()));
        rest = after;
        if rest.is_empty() {
            break;
        }
    }
    // A series of several phases is refused without a number.
    for phase in [None, Some(1)] {
        let choice = Choice {
            phase,
            ..Choice::default()
        };
        match dicom::read_bytes(&files, "fuzz", &choice) {
            Ok(decoded) => {
                assert_eq!(decoded.values().len(), decoded.dims().iter().product::<usize>());
                let _ = open::prepare(&decoded, Window::Stated);
                break;
            }
            Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
        }
    }
});
