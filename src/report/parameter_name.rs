use admire_identify::ParameterFit;

/// Returns the name of an identified parameter: its addresses, and whether their change or their factor is identified.
pub fn parameter_name(parameter: &ParameterFit) -> String {
    let addresses = std::iter::once(&parameter.address).chain(&parameter.tied);
    let names: Vec<&str> = addresses.map(String::as_str).collect();
    form_of(parameter.form, names.join(" = "))
}

/// Puts the form of an identified parameter before its name.
pub(super) fn form_of(form: Option<&str>, name: String) -> String {
    form.map_or_else(|| name.clone(), |form| format!("{form} of {name}"))
}
