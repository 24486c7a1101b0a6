pdlang_macros::model! {
    model spring "Spring"
      cite "Silling 2000, eq. 63"
    {
        param K : pressure > 0 "bulk modulus"
        let c = 2*dim^2*K / ball(x)
        node a = b + sum(s)
        node b = a/2
        energy W = c/4 * sum(x*s^2) * (1 + b)
    }
}

fn main() {
    println!("{}", spring::LAW.name);
}
