pdlang_macros::model! {
    model spring "Spring"
      cite "Silling 2000, eq. 63"
    {
        param K : pressure > 0 "bulk modulus"
        let c = K / ball(x) * case flavour { bar: 2, slab: 2, plane_stres: 8, plane_strain: 8, 3d: 18 }
        energy W = c/4 * sum(x*s^2)
    }
}

fn main() {
    println!("{}", spring::LAW.name);
}
