pdlang_macros::model! {
    model spring "Spring"
      cite "Silling 2000, eq. 63"
    {
        param K  : pressure > 0 "bulk modulus"
        param s0 : number > 0 "critical stretch"
        let c = 2*dim^2*K / ball(x)
        energy W = c/4 * sum(x*s^2)
        break when s0 > 0.1
    }
}

fn main() {
    println!("{}", spring::LAW.name);
}
