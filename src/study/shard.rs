//! Shards: the rows that one process makes.

use std::fmt;
use std::str::FromStr;

/// Shard `index` of so many `shards`, both from 1: the rows whose number leaves `index − 1` when counted from 0 and
/// divided by `shards`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// From 1.
    pub index: u64,
    pub shards: u64,
}

/// The number of tasks of the whole array, set by our own job scripts: a single task that is submitted again is, to
/// Slurm, an array of one.
pub const TASKS_VARIABLE: &str = "CROSSGRAIN_TASKS";

/// More shards than this are more files than a folder should have.
const MOST: u64 = 100_000;

impl Shard {
    /// Everything in one process.
    pub const WHOLE: Shard = Shard {
        index: 1,
        shards: 1,
    };

    pub fn new(index: u64, shards: u64) -> Result<Self, String> {
        if shards == 0 || shards > MOST {
            return Err(format!("{shards} shards; there are 1 to {MOST}"));
        }
        if index == 0 || index > shards {
            return Err(format!(
                "shard {index} of {shards}; shards are counted from 1"
            ));
        }
        Ok(Shard { index, shards })
    }

    /// From the variables of a Slurm job array, read by `variable`. The number of shards is CROSSGRAIN_TASKS, or else
    /// that of the array; tasks are counted from the array's first.
    pub fn from_slurm(variable: impl Fn(&str) -> Option<String>) -> Result<Self, String> {
        let number = |name: &str| -> Result<Option<u64>, String> {
            let wrong = |text| format!("{name} is {text:?}, and must be a whole number");
            let parsed = variable(name).map(|text| text.trim().parse().map_err(|_| wrong(text)));
            parsed.transpose()
        };
        let task = number("SLURM_ARRAY_TASK_ID")?.ok_or_else(|| {
            "--shard auto is for a task of a Slurm job array, and SLURM_ARRAY_TASK_ID is not set; name the shard as \
             I/N, or leave --shard away"
                .to_owned()
        })?;
        if let Some(tasks) = number(TASKS_VARIABLE)? {
            return Shard::new(task, tasks);
        }
        let first = number("SLURM_ARRAY_TASK_MIN")?.unwrap_or(1);
        let step = number("SLURM_ARRAY_TASK_STEP")?.unwrap_or(1).max(1);
        let count = number("SLURM_ARRAY_TASK_COUNT")?.ok_or_else(|| {
            format!("SLURM_ARRAY_TASK_COUNT is not set, and neither is {TASKS_VARIABLE}")
        })?;
        let before = || format!("task {task} stands before the array's first, {first}");
        let place = task.checked_sub(first).ok_or_else(before)?;
        if place % step != 0 || place / step >= count {
            return Err(format!(
                "task {task} is not one of {count} from {first} in steps of {step}: number the array without gaps, as \
                 1-{count}, or set {TASKS_VARIABLE}"
            ));
        }
        Shard::new(place / step + 1, count)
    }

    /// Its rows of so many, in order.
    pub fn rows(&self, count: u64) -> impl Iterator<Item = u64> + use<> {
        (self.index..=count).step_by(self.shards as usize)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}/{}", self.index, self.shards)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong =
            || format!("{text:?} is not a shard; shards are named I/N, such as 3/8, or auto");
        let (index, shards) = text.split_once('/').ok_or_else(wrong)?;
        Shard::new(
            index.parse().map_err(|_| wrong())?,
            shards.parse().map_err(|_| wrong())?,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_belongs_to_one_shard() {
        for shards in [1, 2, 3, 7, 50] {
            let mut seen = vec![0; 41];
            for index in 1..=shards {
                let shard = Shard::new(index, shards).expect("a shard");
                for row in shard.rows(40) {
                    assert_eq!((row - 1) % shards, index - 1);
                    seen[row as usize] += 1;
                }
            }
            assert!(
                seen[1..].iter().all(|times| *times == 1),
                "{shards}: {seen:?}"
            );
        }
    }

    #[test]
    fn tasks_of_an_array_are_shards() {
        let slurm = |task, first, count, tasks: Option<u64>| {
            Shard::from_slurm(|name| {
                let value: Option<u64> = match name {
                    "SLURM_ARRAY_TASK_ID" => task,
                    "SLURM_ARRAY_TASK_MIN" => first,
                    "SLURM_ARRAY_TASK_COUNT" => count,
                    TASKS_VARIABLE => tasks,
                    _ => None,
                };
                value.map(|number| number.to_string())
            })
        };
        let from_zero = slurm(Some(9), Some(0), Some(10), None);
        assert_eq!(from_zero, Shard::new(10, 10));
        // One task again: to Slurm an array of one.
        let again = slurm(Some(3), Some(3), Some(1), Some(8));
        assert_eq!(again, Shard::new(3, 8));
        assert!(slurm(None, None, None, None).is_err());
        let with_gaps = slurm(Some(7), Some(1), Some(3), None);
        assert!(with_gaps.is_err());
    }

    #[test]
    fn names_of_shards() {
        assert_eq!("3/8".parse(), Shard::new(3, 8));
        for wrong in ["0/8", "9/8", "3", "a/b", "1/0", "-1/3", ""] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }
}
