use std::ops::Range;

use super::super::group::NoiseScale;
use super::super::whitening::MarkBlock;
use super::*;
use admire_solver::mechanics::Vec3;
use admire_study::ToleranceSettings;
use admire_study::noise::Noise;

/// Builds a model of two parts with four marks each in six cases, with three stiffnesses and six random effects of two groups.
fn linear(sizes: &VarianceComponents) -> (LinearModel, Whitening, DMatrix<f64>, DVector<f64>) {
    let mut noise = Noise::new(3, "evidence");
    let mut block = |first: usize| MarkBlock {
        rows: (0..4).map(|k| first + 3 * k).collect(),
        levers: (0..4)
            .map(|_| Vec3::from_fn(|_, _| 100.0 * noise.normal()))
            .collect(),
        unit: 0.03,
    };
    let marks: Vec<MarkBlock> = (0..12).map(|k| block(12 * k)).collect();
    let n = 144;
    let mut precision: Vec<f64> = (0..n).map(|_| 1.0 + 0.5 * noise.normal().abs()).collect();
    precision[7] = 0.0;
    let whitening = Whitening::new(&marks, &[], &precision, sizes, &[]);
    let J = DMatrix::from_fn(n, 9, |_, _| 3.0 * noise.normal());
    let z = DVector::from_fn(n, |_, _| 2.0 * noise.normal());
    let unknown = |k: usize| match k {
        0..=2 => Coefficient {
            mean: 0.3,
            sd: 3.0,
            group: None,
            case: None,
        },
        3..=5 => Coefficient::member(EffectGroup::Hardpoints),
        6 => Coefficient {
            sd: 0.4,
            ..Coefficient::member(EffectGroup::LoadGains)
        },
        _ => Coefficient::member(EffectGroup::LoadGains),
    };
    let at = DVector::from_fn(9, |k, _| 0.01 * k as f64);
    let turned = (whitening.apply(&J), whitening.apply_vector(&z));
    let linear = LinearModel::new(
        &whitening,
        &RowsByVarianceClass::new(&whitening, &turned.0),
        &turned.1,
        (0..9).map(unknown).collect(),
        at,
    );
    (linear, whitening, turned.0, turned.1)
}

/// The evidence must equal the Gaussian density of the readings, computed with their full covariance matrix.
#[test]
fn evidence_is_the_density_of_the_readings() {
    let sizes = VarianceComponents::new(&ToleranceSettings::default(), 0.0, [0.0; 2], 1.0);
    let (linear, whitening, J, z) = linear(&sizes);
    let used: Vec<usize> = (0..144)
        .filter(|k| whitening.class_of[*k].is_some())
        .collect();
    assert_eq!(used.len(), 143);
    let (J, z) = (J.select_rows(&used), z.select_rows(&used));
    let density = |sizes: &VarianceComponents| {
        let S2 = DMatrix::from_diagonal(&DVector::from_iterator(
            9,
            linear.unknowns.iter().map(|u| u.prior_sd(sizes).powi(2)),
        ));
        let weights = whitening.weights(&sizes.ln).select_rows(&used);
        let C = &J * S2 * J.transpose() + DMatrix::from_diagonal(&weights.map(|w| 1.0 / (w * w)));
        let from = DVector::from_fn(9, |k, _| linear.unknowns[k].mean - linear.at[k]);
        let r = &z - &J * from;
        let factor = Cholesky::new(C).unwrap();
        let log_det: f64 = factor
            .l_dirty()
            .diagonal()
            .iter()
            .map(|d| 2.0 * d.ln())
            .sum();
        let prior: f64 = sizes
            .ln
            .iter()
            .zip(sizes.each())
            .map(|(ln, s)| s.ln_prior(*ln))
            .sum();
        -0.5 * r.dot(&factor.solve(&r)) - 0.5 * log_det + prior
    };
    let other = sizes.at(sizes.ln.iter().map(|ln| ln + 0.7).collect());
    for sizes in [&sizes, &other] {
        let value = linear.ln_z(sizes);
        assert!(
            (value - density(sizes)).abs() < 1e-6 * value.abs(),
            "{value}"
        );
    }
}

#[test]
fn the_gradient_by_the_sizes_is_that_of_differences() {
    let mut sizes = VarianceComponents::new(&ToleranceSettings::default(), 0.0, [0.0; 2], 1.0);
    sizes.add_scale(NoiseScale::Marks, true);
    let (linear, ..) = linear(&sizes);
    let (_, gradient, _) = linear.evidence(&sizes, true).unwrap();
    for k in 0..sizes.ln.len() {
        let at = |h: f64| {
            let mut ln = sizes.ln.clone();
            ln[k] += h;
            linear.ln_z(&sizes.at(ln))
        };
        let by = (at(1e-5) - at(-1e-5)) / 2e-5;
        assert!(
            (by - gradient[k]).abs() < 1e-4 * (1.0 + by.abs()),
            "{k}: {by} {}",
            gradient[k]
        );
    }
}

/// `Solution::nats_below_maximum` must equal half the excess of the objective over its minimum. For a zero step, this is the gain of the
/// full step.
#[test]
fn a_step_is_below_the_maximum_by_what_it_does_not_gain() {
    let mut sizes = VarianceComponents::new(&ToleranceSettings::default(), 0.0, [0.0; 2], 1.0);
    sizes.add_scale(NoiseScale::Marks, true);
    let (linear, ..) = linear(&sizes);
    let reached = linear.solve(&sizes, 0.0).unwrap();
    assert!(reached.gain > 1.0);
    for part in [0.0, 0.5, 1.0, 3.0] {
        let above = reached.nats_below_maximum(&(part * &reached.step));
        let expected = (part - 1.0_f64).powi(2) * reached.gain;
        assert!((above - expected).abs() < 1e-9 * reached.gain, "{part}");
    }
}

/// A model with appended or replaced columns must have the evidence of a model built from all columns at once.
#[test]
fn a_model_with_other_columns_is_that_made_anew() {
    let sizes = VarianceComponents::new(&ToleranceSettings::default(), 0.0, [0.0; 2], 1.0);
    let (linear, whitening, J, z) = linear(&sizes);
    let unknowns = &linear.unknowns;
    let alike = |a: &LinearModel, b: &LinearModel| {
        let (a, b) = (a.ln_z(&sizes), b.ln_z(&sizes));
        assert!((a - b).abs() < 1e-9 * b.abs(), "{a} {b}");
    };
    let mut at = linear.at.clone();
    at.rows_mut(7, 2).fill(0.0);
    let (known, mut other) = (J.columns(0, 7).into_owned(), J.clone());
    let further = J.columns(7, 2).into_owned();
    let by_class = |J: &DMatrix<f64>| RowsByVarianceClass::new(&whitening, J);
    let (known, J) = (by_class(&known), by_class(&J));
    let columns = |range: Range<usize>| further.columns(range.start, range.len()).into_owned();
    let further = CrossProducts::new(&whitening, &known, &z, &[0..0, 0..2], columns);
    let few = at.rows(0, 7).into_owned();
    let few = LinearModel::new(&whitening, &known, &z, unknowns[..7].to_vec(), few);
    let whole = LinearModel::new(&whitening, &J, &z, unknowns.clone(), at);
    alike(&few.with(&further, 1, 2, unknowns[8]), &whole);

    other.column_mut(3).scale_mut(1.7);
    other.column_mut(8).scale_mut(-0.4);
    let (own, left) = (by_class(&other.select_columns(&[3, 8])), &z * 0.9);
    let at = linear.at.clone();
    let moved = linear.moved(&whitening, &J, &[3, 8], &own, &left, at.clone());
    let anew = LinearModel::new(&whitening, &by_class(&other), &left, unknowns.clone(), at);
    alike(&moved, &anew);
    assert!((moved.ln_z(&sizes) - linear.ln_z(&sizes)).abs() > 1.0);
}

/// A model from which rows were removed must have the evidence of a model built from the remaining rows.
#[test]
fn a_model_without_some_rows_is_that_of_the_others() {
    let sizes = VarianceComponents::new(&ToleranceSettings::default(), 0.0, [0.0; 2], 1.0);
    let (linear, whitening, J, z) = linear(&sizes);
    let left_out: Vec<bool> = (0..144).map(|row| row >= 96).collect();
    let less = linear.without(&whitening, &J, &z, &left_out);
    let rows = |rows: &Vec<usize>| rows.iter().copied().filter(|row| *row < 96).collect();
    let mut few = whitening.clone();
    few.rows_of = whitening.rows_of.iter().map(rows).collect();
    let unknowns = linear.unknowns.clone();
    let other = LinearModel::new(
        &few,
        &RowsByVarianceClass::new(&few, &J),
        &z,
        unknowns,
        linear.at.clone(),
    );
    let (less, other) = (less.ln_z(&sizes), other.ln_z(&sizes));
    assert!((less - other).abs() < 1e-9 * other.abs(), "{less} {other}");
    assert!((less - linear.ln_z(&sizes)).abs() > 1.0);
}
