use super::*;
#[test]
fn smoke() {
    for kind in Kind::ALL {
        for n in [1, 2, 10, 100, 1000, 12345] {
            let mesh = generate(kind, n, 1, &crate::progress::Silent).unwrap();
            println!("{kind} {n} -> {}", mesh.triangle_count());
        }
    }
}
