// The text of the inner call is not the text of its tokens: they are found all the same.
macro_rules! law {
    ($($tokens:tt)*) => {
        pdlang_macros::model! { $($tokens)* }
    };
}

law! {
    model spring "Spring"
      cite "Silling 2000, eq. 63"
    {
        param K : pressure > 0 "bulk modulus"
        let c = 2*dim^2*K / ball(x)
        energy W = c/4 * sum(x*s^2 + K)
    }
}

fn main() {
    println!("{}", spring::LAW.name);
}
