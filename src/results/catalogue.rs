/// One column of results.
#[derive(Clone, PartialEq, Eq, Debug, serde::Serialize, serde::Deserialize)]
pub struct Component {
    /// Name inside its entity, for example `FX`.
    pub name: String,
    /// Unit as the file spells it, for example `newton-mm`; variables have none.
    pub units: Option<String>,
    /// What to write beside the axis of a plot; some requests have it.
    pub plot_label: Option<String>,
    /// 1-based position of the value in every step.
    pub id: usize,
}

/// An object of the model that has results.
#[derive(Clone, PartialEq, Eq, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Entity {
    /// Name of the result set, for example `arm_XFORM`.
    pub name: String,
    /// Name of the object, without the name of the model, for example `testrig.arm`.
    pub entity: Option<String>,
    /// Kind of the object, for example `Part`.
    pub ent_type: Option<String>,
    /// Id of the statement.
    pub object_id: Option<i64>,
    /// Comment of a request.
    pub comment: Option<String>,
    /// Columns.
    pub components: Vec<Component>,
}

impl Entity {
    /// A component by name, upper and lower case alike.
    pub fn component(&self, name: &str) -> Option<&Component> {
        self.components
            .iter()
            .find(|component| component.name.eq_ignore_ascii_case(name))
    }
}

/// The names of all columns: the StepMap of an XRF file.
#[derive(Clone, PartialEq, Eq, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Catalogue {
    /// Name of the map.
    pub name: String,
    /// Entities in the order of the file.
    pub entities: Vec<Entity>,
}

/// A component together with the entity it belongs to.
#[derive(Clone, Copy, Debug)]
pub struct Column<'a> {
    /// The entity.
    pub entity: &'a Entity,
    /// The component of it.
    pub component: &'a Component,
}

impl Catalogue {
    /// A catalogue under the name ADAMS gives it.
    pub fn new(entities: Vec<Entity>) -> Self {
        Self {
            name: "map_001".to_string(),
            entities,
        }
    }

    /// Number of values in a step: the largest id.
    pub fn len(&self) -> usize {
        self.columns().map(|c| c.component.id).max().unwrap_or(0)
    }

    /// True if there is no component at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All columns in the order of the file.
    pub fn columns(&self) -> impl Iterator<Item = Column<'_>> {
        self.entities.iter().flat_map(|entity| {
            entity
                .components
                .iter()
                .map(move |component| Column { entity, component })
        })
    }

    /// Columns by position: element i has id i + 1. A position without a name is `None`.
    pub fn by_position(&self) -> Vec<Option<Column<'_>>> {
        let mut columns = vec![None; self.len()];
        for column in self.columns() {
            if column.component.id > 0 {
                columns[column.component.id - 1] = Some(column);
            }
        }
        columns
    }

    /// The entities called `name`, as result set or as object, upper and lower case alike.
    pub fn entities_called<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Entity> {
        self.entities.iter().filter(move |entity| {
            entity.name.eq_ignore_ascii_case(name)
                || entity
                    .entity
                    .as_deref()
                    .is_some_and(|object| object.eq_ignore_ascii_case(name))
        })
    }

    /// The entity of a statement: by kind (`Part`) and id.
    pub fn entity_of(&self, ent_type: &str, object_id: i64) -> Option<&Entity> {
        self.entities.iter().find(|entity| {
            entity.object_id == Some(object_id) && entity.ent_type.as_deref() == Some(ent_type)
        })
    }
}

impl Column<'_> {
    /// `ENTITY.COMPONENT`, with the object's full name: `testrig.arm_XFORM.X`. Result sets of nested objects share their
    /// short names, full names tell them apart.
    pub fn path(&self) -> String {
        let name = &self.entity.name;
        let component = &self.component.name;
        let full = self.entity.entity.as_deref();
        let owner = full.and_then(|full| full.rsplit_once('.'));
        match owner {
            // A result set may be called by its full name already: `Brake.Brake_Moment`.
            Some((owner, _)) if !is_in(name, owner) => format!("{owner}.{name}.{component}"),
            _ => format!("{name}.{component}"),
        }
    }
}

/// True for a name that begins with its owner's.
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
