//! Sweeps the stiffness of a bushing and plots the displacement of the wheel: `cargo run --release --example sweep_a_stiffness`.

use admire::{Deck, Error};

fn main() -> Result<(), Error> {
    let mut deck = Deck::open("corpus/pseudo-mcpherson/model.adm")?;
    deck.set("SFORCE/1", 1000.0)?;
    let mut points = Vec::new();
    for step in 0..=20 {
        let stiffness = 1000.0 * 10.0_f64.powf(f64::from(step) / 20.0);
        deck.set("BUSHING/*.K.1", stiffness)?;
        let run = deck.solve()?;
        // The column has one value per step of the run: the deck as it was read, then its equilibrium.
        let place = run.column("KNUCKLE.X")?;
        points.push((stiffness, place[1] - place[0]));
    }
    for (stiffness, moved) in &points {
        println!("{stiffness:8.0} N/mm  {moved:8.4} mm");
    }
    let file = std::env::temp_dir().join("admire-sweep.svg");
    std::fs::write(&file, plot(&points)).expect("a temporary file");
    println!("plot: {}", file.display());
    Ok(())
}

/// Draws a line through the points as SVG, with a logarithmic horizontal axis and a linear vertical axis.
fn plot(points: &[(f64, f64)]) -> String {
    let least = points.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
    let most = points.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
    let (first, last) = (points[0].0, points[points.len() - 1].0);
    let place = |(x, y): &(f64, f64)| {
        let across = 60.0 + 500.0 * (x / first).ln() / (last / first).ln();
        let down = 340.0 - 300.0 * (y - least) / (most - least);
        format!("{across:.1},{down:.1}")
    };
    let line: Vec<String> = points.iter().map(place).collect();
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 600 400\" font-family=\"sans-serif\" font-size=\"14\">\
         <polyline points=\"{}\" fill=\"none\" stroke=\"#0072b2\" stroke-width=\"2\"/>\
         <text x=\"60\" y=\"380\">{first:.0} N/mm</text><text x=\"560\" y=\"380\" text-anchor=\"end\">{last:.0} N/mm</text>\
         <text x=\"10\" y=\"44\">{most:.3} mm</text><text x=\"10\" y=\"340\">{least:.3} mm</text></svg>\n",
        line.join(" ")
    )
}
