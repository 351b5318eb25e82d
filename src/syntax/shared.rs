use std::fmt;
use std::ops::Deref;
use std::sync::{Arc, OnceLock};

/// A slice of a list that several owners share.
///
/// A deck has millions of lists with two or three values; allocating each of them separately would take longer than parsing them.
pub struct Shared<T> {
    list: Option<Arc<OnceLock<Box<[T]>>>>,
    start: u32,
    length: u32,
}

impl<T> Deref for Shared<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        let all = self.list.as_ref().and_then(|list| list.get());
        let start = self.start as usize;
        all.map_or(&[], |all| &all[start..start + self.length as usize])
    }
}

impl<T> Clone for Shared<T> {
    fn clone(&self) -> Self {
        Self {
            list: self.list.clone(),
            ..*self
        }
    }
}

impl<T> Default for Shared<T> {
    fn default() -> Self {
        Self {
            list: None,
            start: 0,
            length: 0,
        }
    }
}

impl<T: PartialEq> PartialEq for Shared<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: fmt::Debug> fmt::Debug for Shared<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

impl<'a, T> IntoIterator for &'a Shared<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<T> FromIterator<T> for Shared<T> {
    fn from_iter<I: IntoIterator<Item = T>>(values: I) -> Self {
        let mut pool = Pool::new();
        let shared = pool.share(values);
        pool.close();
        shared
    }
}

/// A growing list that hands out slices of itself. The slices appear empty until the list is closed.
pub(super) struct Pool<T> {
    list: Arc<OnceLock<Box<[T]>>>,
    open: Vec<T>,
}

impl<T> Pool<T> {
    pub(crate) fn new() -> Self {
        Self {
            list: Arc::default(),
            open: Vec::new(),
        }
    }

    /// Appends values to the list and returns the slice that contains them.
    pub(crate) fn share(&mut self, values: impl IntoIterator<Item = T>) -> Shared<T> {
        let start = self.open.len();
        self.open.extend(values);
        if self.open.len() == start {
            return Shared::default();
        }
        // A list holds the values of a few hundred lines, so 32 bits suffice; a file with more than 2^32 values does not fit into memory.
        let small = |at: usize| u32::try_from(at).unwrap_or(u32::MAX);
        Shared {
            list: Some(Arc::clone(&self.list)),
            start: small(start),
            length: small(self.open.len() - start),
        }
    }

    /// Closes the list. All slices handed out so far then contain their values; before, they appear empty.
    pub(crate) fn close(&mut self) {
        let list = std::mem::take(&mut self.list);
        // The list was created by the previous call or by `new`, so it cannot be set already.
        let _ = list.set(self.open.drain(..).collect());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_see_their_values_once_the_pool_is_closed() {
        let mut pool = Pool::new();
        let first = pool.share([1, 2, 3]);
        let none = pool.share([]);
        let second = pool.share([4]);
        assert!(first.is_empty());
        pool.close();
        let third = pool.share([5]);
        pool.close();
        assert_eq!((&*first, &*none), (&[1, 2, 3][..], &[][..]));
        assert_eq!((&*second, &*third), (&[4][..], &[5][..]));
        assert_eq!(second.clone(), second);
        assert_eq!(format!("{first:?}"), "[1, 2, 3]");
    }
}
