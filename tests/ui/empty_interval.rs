pdlang_macros::model! {
    model spring "Spring"
      cite "Silling 2000, eq. 63"
    {
        param K  : pressure > 0 "bulk modulus"
        param nu : number in (0.5, 0) "Poisson's ratio"
        let c = 2*dim^2*K*(1 - nu) / ball(x)
        energy W = c/4 * sum(x*s^2)
    }
}

fn main() {
    println!("{}", spring::LAW.name);
}
