pdlang_macros::model! {
    model spring "Spring"
      cite "Silling 2000, eq. 63"
    {
        param K : pressure > 0 "bulk modulus"
        let c = 2*dim^2*K / ball(x);
        energy W = c/4 * sum(x*s^2)
    }
}

fn main() {
    println!("{}", spring::LAW.name);
}
