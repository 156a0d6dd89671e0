//! What an engine writes is believed only as far as its tables prove it.

use super::broken::fails;
use crate::support::rows;

/// What the engine does, and what is said of it.
const BROKEN: &str = r#"
    put('moments.jsonl', ''); put('done.json', '{"steps": 10}') ⇒ not one moment
    put('moments.jsonl', 'rubbish\n') ⇒ moments.jsonl: expected value
    put('moments.jsonl', '[' * 100000) ⇒ moments.jsonl
    finish([{'colour': 'red'}]) ⇒ moments.jsonl
    finish([{'stage': 'settle', 'step': 0}, end(10)]) ⇒ settle-0-bodies.csv
    finish([moment(0, given.replace('0.', 'nan', 1)), moment(10), end(10)]) ⇒ step 0: settle-0-bodies.csv is not a table
    finish([moment(0, '\n'.join(given.split('\n')[:2]) + '\n')]) ⇒ 1 grains instead of 2
    finish([moment(0, given[:-5])]) ⇒ cut off
    finish([moment(0, given * 2000)]) ⇒ larger than
    rows = given.split('\n'); rows[1] = ','.join(rows[1].split(',')[:-1] + ['1.0']); finish([moment(0, '\n'.join(rows))]) ⇒ other radii, masses
    rows = given.split('\n'); row = rows[1].split(','); row[1] = '0.011'; rows[1] = ','.join(row); finish([moment(0, '\n'.join(rows)), moment(10), end(10)]) ⇒ not the start that it was given
    finish([moment(0, contacts=EMPTY + '0,77,0,0,0,1,0,0,0\n')]) ⇒ id2 = 77
    finish([moment(0, contacts=EMPTY + '1,0,0,0,0,1,0,0,0\n')]) ⇒ the lower id stands first
    finish([moment(0, contacts=EMPTY + '0,1,-1,0,0,1,0,0,0\n')]) ⇒ only what touches is a contact
    finish([moment(0, contacts=EMPTY + '0,1,0,0,0,1,1,0,0\n')]) ⇒ of length 1
    finish([moment(0, contacts=EMPTY + '0,1,0,inf,0,1,0,0,0\n')]) ⇒ fn = inf
    finish([moment(0, contacts=EMPTY + '0,1,9,0,0,1,0,0,0\n'), moment(10), end(10)]) ⇒ overlap by 9
    finish([moment(0), moment(10)]) ⇒ none was finished
    finish([moment(0), moment(7), end(7)]) ⇒ 10 steps were asked for and 7 were done
    finish([moment(0), moment(9), end(10)]) ⇒ moment 1 of the run should be settle 10 and is settle 9
    finish([moment(0), moment(10), end(10), moment(11)]) ⇒ moment 2 of the run should be none
    finish([moment(0), moment(10), end(10, 'settled')]) ⇒ its stages are not those of the task
    finish([moment(0), moment(10), end(10, 'bored')]) ⇒ the stop reason
    finish([moment(0), end(10**15, 'max_steps')]) ⇒ its stages are not those of the task
    finish([moment(0), moment(10), end(10)], steps=9) ⇒ it counts 9 steps
    finish([moment(0), moment(10), end(10)]); os.remove(os.path.join(job, 'done.json')) ⇒ before the job was done
    finish([{'refused': 'no discs today'}]) ⇒ the engine refused: no discs today
    os.symlink('/dev/zero', os.path.join(job, 'moments.jsonl')) ⇒ not a regular file
    os.mkfifo(os.path.join(job, 'moments.jsonl')) ⇒ not a regular file
"#;

#[test]
fn tables_are_not_believed_blindly() {
    // It writes nothing.
    fails("", "", "its list of moments is not there");
    for [does, message] in rows(BROKEN) {
        fails("", does, message);
    }
}
