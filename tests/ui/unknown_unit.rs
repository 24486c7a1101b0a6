pdlang_macros::model! {
    model spring "Spring"
      cite "Silling 2000, eq. 63"
    {
        param c : [Paa/m^4] > 0 "micromodulus"
        energy W = c/4 * sum(x*s^2)
    }
}

fn main() {
    println!("{}", spring::LAW.name);
}
