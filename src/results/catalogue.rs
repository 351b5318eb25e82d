/// One column of results: a single quantity of one object.
#[derive(Clone, PartialEq, Eq, Debug, serde::Serialize, serde::Deserialize)]
pub struct Component {
    /// Name of the column inside its entity, for example `FX`.
    pub name: String,
    /// Unit as spelled in the file, for example `newton-mm`; `None` for columns without a unit, such as variables.
    pub units: Option<String>,
    /// Label for the axis of a plot; only the columns of some requests have one.
    pub plot_label: Option<String>,
    /// Id of the column: the 1-based position of its value in every output step.
    pub id: usize,
}

/// Result columns of one object of the model; an Entity element of an XRF file.
#[derive(Clone, PartialEq, Eq, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Entity {
    /// Name of the result set, for example `arm_XFORM`.
    pub name: String,
    /// Name of the object without the name of the model, for example `testrig.arm`.
    pub entity: Option<String>,
    /// Kind of the object, for example `Part`.
    pub ent_type: Option<String>,
    /// Id of the statement that defines the object in the dataset.
    pub object_id: Option<i64>,
    /// Comment of a request; `None` for other objects.
    pub comment: Option<String>,
    /// Columns of the object.
    pub components: Vec<Component>,
}

impl Entity {
    /// Returns the column with this name inside the entity; case is ignored.
    pub fn component(&self, name: &str) -> Option<&Component> {
        self.components
            .iter()
            .find(|component| component.name.eq_ignore_ascii_case(name))
    }
}

/// Names of all result columns; the StepMap element of an XRF file.
#[derive(Clone, PartialEq, Eq, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Catalogue {
    /// Name of the StepMap.
    pub name: String,
    /// Entities in the order of the file.
    pub entities: Vec<Entity>,
}

/// A column of results, together with the entity to which it belongs.
#[derive(Clone, Copy, Debug)]
pub struct Column<'a> {
    /// Entity to which the column belongs.
    pub entity: &'a Entity,
    /// The column itself, with its name inside the entity.
    pub component: &'a Component,
}

impl Catalogue {
    /// Creates a catalogue named `map_001`, as in ADAMS.
    pub fn new(entities: Vec<Entity>) -> Self {
        Self {
            name: "map_001".to_string(),
            entities,
        }
    }

    /// Returns the number of values in an output step, which is the largest column id.
    pub fn len(&self) -> usize {
        self.columns().map(|c| c.component.id).max().unwrap_or(0)
    }

    /// Returns true if the catalogue has no columns.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Iterates over all columns, in the order of the file.
    pub fn columns(&self) -> impl Iterator<Item = Column<'_>> {
        self.entities.iter().flat_map(|entity| {
            entity
                .components
                .iter()
                .map(move |component| Column { entity, component })
        })
    }

    /// Returns the columns by position: the element at index i has the id i + 1. A position that no column uses is `None`.
    pub fn by_position(&self) -> Vec<Option<Column<'_>>> {
        let mut columns = vec![None; self.len()];
        for column in self.columns() {
            if column.component.id > 0 {
                columns[column.component.id - 1] = Some(column);
            }
        }
        columns
    }

    /// Iterates over the entities whose result set or whose object has this name; case is ignored.
    pub fn entities_called<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Entity> {
        self.entities.iter().filter(move |entity| {
            entity.name.eq_ignore_ascii_case(name)
                || entity
                    .entity
                    .as_deref()
                    .is_some_and(|object| object.eq_ignore_ascii_case(name))
        })
    }

    /// Returns the entity of an object, given the object's kind in results files (such as `Part`) and the id of its statement.
    pub fn entity_of(&self, ent_type: &str, object_id: i64) -> Option<&Entity> {
        self.entities.iter().find(|entity| {
            entity.object_id == Some(object_id) && entity.ent_type.as_deref() == Some(ent_type)
        })
    }
}

impl Column<'_> {
    /// Returns the full name of the column: `ENTITY.COMPONENT`, preceded by the owner of the object, as in `testrig.arm_XFORM.X`.
    ///
    /// Result sets of nested objects may have the same short name; the owner makes the full name unique.
    pub fn path(&self) -> String {
        let name = &self.entity.name;
        let component = &self.component.name;
        let full = self.entity.entity.as_deref();
        let owner = full.and_then(|full| full.rsplit_once('.'));
        match owner {
            // The name of a result set may already contain its owner: `Brake.Brake_Moment`.
            Some((owner, _)) if !is_in(name, owner) => format!("{owner}.{name}.{component}"),
            _ => format!("{name}.{component}"),
        }
    }
}

/// Returns true if `name` begins with the name of the owner and a dot.
fn is_in(name: &str, owner: &str) -> bool {
    let rest = name.strip_prefix(owner);
    rest.is_some_and(|rest| rest.starts_with('.'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_word_of_a_name_is_there_twice() {
        let component = Component {
            name: "X".to_string(),
            units: None,
            plot_label: None,
            id: 2,
        };
        for (name, full, path) in [
            ("arm_XFORM", "testrig.arm", "testrig.arm_XFORM.X"),
            (
                "Brake.Brake_Moment",
                "Brake.Brake_Moment",
                "Brake.Brake_Moment.X",
            ),
            ("Brake_Moment", "Brake.Brake_Moment", "Brake.Brake_Moment.X"),
            ("Brakes", "Brake.Brakes", "Brake.Brakes.X"),
            ("travel", "travel", "travel.X"),
        ] {
            let entity = Entity {
                name: name.to_string(),
                entity: Some(full.to_string()),
                ..Entity::default()
            };
            let column = Column {
                entity: &entity,
                component: &component,
            };
            assert_eq!(column.path(), path);
        }
    }
}
