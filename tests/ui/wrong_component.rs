pdlang_macros::model! {
    model spring "Spring"
      cite "Silling 2000, eq. 63"
    {
        param K : pressure > 0 "bulk modulus"
        let c = 2*dim^2*K / ball(x)
        energy W = c/4 * sum(x*s^2)
        probe two_nodes in 3d where K = 1 GPa, delta = 2 mm {
            node a = (0, 0), V = 1 mm^3
            node b = (1 mm, 0, 0), V = 1 mm^3
            expect s(a, c) = 0
        }
    }
}

fn main() {
    println!("{}", spring::LAW.name);
}
