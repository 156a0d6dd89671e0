//! One engine with many ways to be broken: each ends within its limits, in little memory, with its own sentence and exit code,
//! and leaves no process and no folder behind. What is only odd is believed as far as its tables prove it.

use std::sync::Mutex;

use crossgrain::workers;

use crate::support::*;

/// What each of them can use.
const TOOLS: &str = r#"
import array, resource, shutil, signal
resource.setrlimit(resource.RLIMIT_AS, (resource.RLIM_INFINITY,) * 2)
def at(name): return os.path.join(job, name)
def well(): finish([moment(0), moment(10), end(10)])
def instead(name, make): os.remove(at(name)); make(at(name))
def numbers():
    columns = list(zip(*[row.split(',') for row in given.split('\n')[1:-1]]))
    return array.array('d', [float(value) for column in columns[1:5] for value in column]).tobytes()
def grow(name, line, first=bool):
    if os.fork(): return time.sleep(0.3)
    first()
    while True:
        with open(at(name), 'a') as table: table.write(line)
        time.sleep(0.001)
def cell(row, column, value):
    rows = [row.split(',') for row in given.split('\n')]
    rows[row][column] = value
    return '\n'.join(','.join(row) for row in rows)
"#;

/// A name, what it says of itself or does, what is said of it, and the exit code.
const HOSTILE: &str = r#"
    speaks another protocol ⇒ SAY = lambda: describe(protocol=3) ⇒ speaks version 3 of the protocol ⇒ 4
    speaks a protocol of the far future ⇒ SAY = lambda: describe(protocol=99999999999) ⇒ speaks version 99999999999 ⇒ 4
    has a part that nobody knows ⇒ SAY = lambda: describe(parts=['normal_spring', 'magic']) ⇒ magic ⇒ 4
    has no parts ⇒ SAY = lambda: describe(parts=[]) ⇒ no normal_spring ⇒ 4
    has no name ⇒ SAY = lambda: describe(name=' ') ⇒ its name is empty ⇒ 4
    has a name of two lines ⇒ SAY = lambda: describe(name='a\nb') ⇒ without line breaks ⇒ 4
    describes itself with a key that nobody knows ⇒ SAY = lambda: describe(colour='red') ⇒ colour ⇒ 4
    says what is no JSON ⇒ SAY = lambda: (print('hello'), sys.exit()) ⇒ it printed "hello ⇒ 4
    says nothing of itself ⇒ SAY = lambda: sys.exit() ⇒ EOF ⇒ 4
    ends instead of describing itself ⇒ SAY = lambda: sys.exit('no licence') ⇒ no licence ⇒ 4
    describes itself without end ⇒ SAY = lambda: (print('x' * 100000), sys.exit()) ⇒ larger than ⇒ 4
    says nothing for ever ⇒ SAY = lambda: time.sleep(600) ⇒ not done within 8s ⇒ 4
    leaves a key of its description away ⇒ SAY = lambda: (print('{"protocol": 1, "name": "x", "parts": []}'), sys.exit()) ⇒ missing field `version` ⇒ 4
    lacks what is asked for ⇒ SAY = lambda: describe(parts=['normal_spring', 'gravity', 'walls']) ⇒ broken has no Cundall's damping ⇒ 2
    writes no moments ⇒ put('moments.jsonl', ''); put('done.json', '{"steps": 10}') ⇒ not one moment ⇒ 4
    writes rubbish ⇒ put('moments.jsonl', 'rubbish\n') ⇒ moments.jsonl: expected value ⇒ 4
    writes a force that is none ⇒ put('moments.jsonl', '{"stage": "settle", "step": 0, "loads": [[NaN, 0, 0]]}\n') ⇒ moments.jsonl: a nan among its numbers ⇒ 4
    writes deep JSON ⇒ put('moments.jsonl', '[' * 100000) ⇒ moments.jsonl ⇒ 4
    uses a key that nobody knows ⇒ finish([{'colour': 'red'}]) ⇒ moments.jsonl ⇒ 4
    leaves a table away ⇒ finish([{'stage': 'settle', 'step': 0}, end(10)]) ⇒ settle-0-bodies.csv ⇒ 4
    writes what is no number ⇒ finish([moment(0, given.replace('0.', 'nan', 1)), moment(10), end(10)]) ⇒ step 0: settle-0-bodies.csv is not a table ⇒ 4
    loses a grain ⇒ finish([moment(0, '\n'.join(given.split('\n')[:2]) + '\n')]) ⇒ 1 grains instead of 2 ⇒ 4
    cuts a table off ⇒ finish([moment(0, given[:-5])]) ⇒ cut off ⇒ 4
    writes a table that is too large ⇒ finish([moment(0, given * 2000)]) ⇒ larger than ⇒ 4
    changes a mass ⇒ rows = given.split('\n'); rows[1] = ','.join(rows[1].split(',')[:-1] + ['1.0']); finish([moment(0, '\n'.join(rows))]) ⇒ other radii, masses ⇒ 4
    begins elsewhere ⇒ rows = given.split('\n'); row = rows[1].split(','); row[1] = '0.011'; rows[1] = ','.join(row); finish([moment(0, '\n'.join(rows)), moment(10), end(10)]) ⇒ not the start that it was given ⇒ 4
    touches nobody ⇒ finish([moment(0, contacts=EMPTY + '0,77,0,0,0,1,0,0,0\n')]) ⇒ id2 = 77 ⇒ 4
    turns a contact round ⇒ finish([moment(0, contacts=EMPTY + '1,0,0,0,0,1,0,0,0\n')]) ⇒ the lower id stands first ⇒ 4
    has a contact that does not touch ⇒ finish([moment(0, contacts=EMPTY + '0,1,-1,0,0,1,0,0,0\n')]) ⇒ only what touches is a contact ⇒ 4
    has a normal of no length ⇒ finish([moment(0, contacts=EMPTY + '0,1,0,0,0,1,1,0,0\n')]) ⇒ of length 1 ⇒ 4
    has a force without bound ⇒ finish([moment(0, contacts=EMPTY + '0,1,0,inf,0,1,0,0,0\n')]) ⇒ fn = inf ⇒ 4
    has a force without an energy ⇒ finish([moment(0, contacts=EMPTY + '0,1,1e-6,1.7e308,1.7e308,1,0,0,0\n'), moment(10), end(10)]) ⇒ too large for an energy ⇒ 4
    overlaps too deeply ⇒ finish([moment(0, contacts=EMPTY + '0,1,9,0,0,1,0,0,0\n'), moment(10), end(10)]) ⇒ overlap by 9 ⇒ 4
    never ends a stage ⇒ finish([moment(0), moment(10)]) ⇒ none was finished ⇒ 4
    does too few steps ⇒ finish([moment(0), moment(7), end(7)]) ⇒ 10 steps were asked for and 7 were done ⇒ 4
    forgets the last moment ⇒ finish([moment(0), moment(9), end(10)]) ⇒ moment 1 of the run should be settle 10 and is settle 9 ⇒ 4
    goes on after its end ⇒ finish([moment(0), moment(10), end(10), moment(11)]) ⇒ moment 2 of the run should be none ⇒ 4
    ends by a rule that was not asked for ⇒ finish([moment(0), moment(10), end(10, 'settled')]) ⇒ its stages are not those of the task ⇒ 4
    ends for a reason of its own ⇒ finish([moment(0), moment(10), end(10, 'bored')]) ⇒ the stop reason ⇒ 4
    ends beyond all counts ⇒ finish([moment(0), end(10**15, 'max_steps')]) ⇒ its stages are not those of the task ⇒ 4
    counts its steps wrongly ⇒ finish([moment(0), moment(10), end(10)], steps=9) ⇒ it counts 9 steps ⇒ 4
    takes its last word back ⇒ finish([moment(0), moment(10), end(10)]); os.remove(os.path.join(job, 'done.json')) ⇒ before the job was done ⇒ 4
    refuses ⇒ finish([{'refused': 'no discs today'}]) ⇒ the engine refused: no discs today ⇒ 4
    links its list to a device ⇒ os.symlink('/dev/zero', os.path.join(job, 'moments.jsonl')) ⇒ a symbolic link ⇒ 4
    puts a pipe in the place of its list ⇒ os.mkfifo(os.path.join(job, 'moments.jsonl')) ⇒ not a regular file ⇒ 4
    is silent ⇒ time.sleep(600) ⇒ no sign of life ⇒ 4
    hangs once it is done ⇒ well(); time.sleep(600) ⇒ no sign of life ⇒ 4
    talks for ever ⇒ [(print('settle 1 0.1'), time.sleep(0.05)) for i in range(10**6)] ⇒ not done within ⇒ 4
    ignores every signal and hangs ⇒ [signal.signal(s, signal.SIG_IGN) for s in (1, 2, 3, 15)]; time.sleep(600) ⇒ no sign of life ⇒ 4
    forks, and child and parent hang ⇒ os.fork(); os.fork(); time.sleep(600) ⇒ no sign of life ⇒ 4
    stops itself ⇒ os.kill(os.getpid(), signal.SIGSTOP) ⇒ no sign of life ⇒ 4
    floods its standard output ⇒ [print('x' * 100000) for i in range(10**6)] ⇒ MB of output ⇒ 4
    floods its standard error ⇒ [sys.stderr.write('x' * 100000) for i in range(10**6)] ⇒ MB of output ⇒ 4
    floods the disk from below ⇒ os.makedirs(at('d/e')); put('d/e/x', 'x' * (20 << 20)); time.sleep(600) ⇒ MB of output ⇒ 4
    eats memory ⇒ heap = bytearray(os.urandom(1 << 20) * 400); time.sleep(600) ⇒ MB of memory ⇒ 4
    eats memory in a child ⇒ os.fork() or (bytearray(os.urandom(1 << 20) * 400), time.sleep(600)); time.sleep(600) ⇒ MB of memory ⇒ 4
    writes a table of 5 GB that is all holes ⇒ put('t', ''); os.truncate(at('t'), 5 << 30); time.sleep(600) ⇒ MB of output ⇒ 4
    ends well without a result ⇒ sys.exit(0) ⇒ its list of moments is not there ⇒ 4
    fails without a word ⇒ sys.exit(7) ⇒ ended with exit status: 7; it printed nothing ⇒ 4
    fails with a whole result ⇒ well(); sys.exit(9) ⇒ ended with exit status: 9 ⇒ 4
    ends by a signal ⇒ well(); os.kill(os.getpid(), 11) ⇒ signal: 11 ⇒ 4
    raises ⇒ raise ValueError('the reason') ⇒ ValueError: the reason ⇒ 4
    puts a pipe in the place of its log ⇒ os.remove(at('engine.log')); os.mkfifo(at('engine.log')); sys.exit(3) ⇒ ended with exit status: 3 ⇒ 4
    links its log to a file outside ⇒ os.remove(at('engine.log')); os.symlink('/etc/passwd', at('engine.log')); sys.exit(3) ⇒ it printed nothing ⇒ 4
    links its parameters to a hole ⇒ well(); put('effective.json', ''); os.truncate(at('effective.json'), 300 << 30) ⇒ MB of output ⇒ 4
    changes its own program ⇒ well(); open(sys.argv[0], 'a').write('#') ⇒ was replaced while it ran ⇒ 4
    removes the folder of its job ⇒ shutil.rmtree(job) ⇒ its list of moments is not there ⇒ 4
    puts a link in the place of its job ⇒ shutil.rmtree(job); os.symlink('/etc', job) ⇒ its list of moments is not there ⇒ 4
    takes the name of the result ⇒ well(); os.mkdir(at('../out')) ⇒ exists already ⇒ 2
    writes a list of deep JSON after a good line ⇒ finish([moment(0), [[[[1]]]]]) ⇒ moments.jsonl: expected value ⇒ 4
    counts in numbers that are too large ⇒ finish([moment(0), moment(10) | {'step': 2**64}, end(10)]) ⇒ moments.jsonl: invalid type ⇒ 4
    counts below nothing ⇒ finish([moment(0), moment(10) | {'step': -1}, end(10)]) ⇒ moments.jsonl: invalid value ⇒ 4
    leaves a key away ⇒ finish([{'stage': 'settle'}]) ⇒ missing field `step` ⇒ 4
    goes back in time ⇒ finish([moment(0), moment(10), moment(5), end(10)]) ⇒ moment 2 of the run should be none and is settle 5 ⇒ 4
    says a moment twice ⇒ finish([moment(0), moment(0), moment(10), end(10)]) ⇒ moment 1 of the run should be settle 10 and is settle 0 ⇒ 4
    does a step too many ⇒ finish([moment(0), moment(10), moment(11), end(11)], steps=11) ⇒ 10 steps were asked for and 11 were done ⇒ 4
    ends twice ⇒ finish([moment(0), moment(10), end(10), end(10)]) ⇒ its stages are not those of the task ⇒ 4
    took less than no time ⇒ finish([moment(0), moment(10), end(10) | {'wall_seconds': -1}]) ⇒ times that are below 0 ⇒ 4
    says of itself that its numbers are no numbers ⇒ finish([moment(0), moment(10), end(10, 'not_finite')]) ⇒ numbers that are not finite in step 10 ⇒ 4
    gives two grains one id ⇒ finish([moment(0, cell(2, 0, '0'))]) ⇒ id = 0, which must be the row's number ⇒ 4
    adds a grain ⇒ finish([moment(0, given + given.split('\n')[-2].replace('1,', '2,', 1) + '\n')]) ⇒ 3 grains instead of 2 ⇒ 4
    makes a row too short ⇒ finish([moment(0, given.rsplit(',', 1)[0] + '\n')]) ⇒ line 3 has 6 fields ⇒ 4
    makes a row too long ⇒ finish([moment(0, given[:-1] + ',1\n')]) ⇒ line 3 has 8 fields ⇒ 4
    makes a radius negative ⇒ finish([moment(0, cell(1, 5, '-0.01'))]) ⇒ radius = -0.01, which must be finite and above 0 ⇒ 4
    moves a grain without bound ⇒ finish([moment(0), moment(10, cell(1, 1, 'inf')), end(10)]) ⇒ x = inf, which must be finite ⇒ 4
    moves a grain out of the box ⇒ finish([moment(0), moment(10, cell(1, 1, '1e300')), end(10)]) ⇒ has left the box ⇒ 4
    swaps two columns ⇒ finish([moment(0, given.replace('id,x,z', 'id,z,x'))]) ⇒ not the start that it was given ⇒ 4
    writes bytes that are no text ⇒ finish([moment(0)]); open(at('settle-0-bodies.csv'), 'wb').write(b'\xff\xfe\n') ⇒ not UTF-8 ⇒ 4
    begins its list with a byte order mark ⇒ well(); put('moments.jsonl', '\ufeff' + open(at('moments.jsonl')).read()) ⇒ moments.jsonl: expected value ⇒ 4
    puts a pipe in the place of a table ⇒ well(); instead('settle-10-bodies.csv', os.mkfifo) ⇒ is not a regular file ⇒ 4
    puts a folder in the place of a table ⇒ well(); instead('settle-10-contacts.csv', os.mkdir) ⇒ is a folder ⇒ 4
    puts a device in the place of a table ⇒ well(); instead('settle-10-bodies.csv', lambda of: os.symlink('/dev/zero', of)) ⇒ a symbolic link ⇒ 4
    links a table to another one ⇒ well(); instead('settle-10-bodies.csv', lambda of: os.symlink('settle-0-bodies.csv', of)) ⇒ a symbolic link ⇒ 4
    links its last word to a file outside ⇒ well(); instead('done.json', lambda of: os.symlink('/etc/passwd', of)) ⇒ a symbolic link ⇒ 4
    puts a pipe in the place of its numbers ⇒ os.mkfifo(at('tables.bin')); finish([moment(0) | {'contacts': 0}]) ⇒ tables.bin: ⇒ 4
    promises more contacts than there can be ⇒ put('tables.bin', 'x' * 64); finish([moment(0) | {'contacts': 2**60}]) ⇒ 1152921504606846976 contacts ⇒ 4
    cuts its numbers off ⇒ put('tables.bin', 'x' * 63); finish([moment(0) | {'contacts': 0}]) ⇒ tables.bin is cut off ⇒ 4
    lets a table grow while it is read ⇒ well(); grow('settle-10-bodies.csv', 'x\n') ⇒ step 10: settle-10-bodies.csv is ⇒ 4
    lets a table grow from a session of its own ⇒ well(); grow('settle-10-contacts.csv', 'x\n', os.setsid) ⇒ settle-10-contacts.csv is not a table ⇒ 4
    lets its list grow while it is read ⇒ well(); grow('moments.jsonl', '{"stage": "settle", "step": 10}\n') ⇒ moment 2 of the run should be none ⇒ 4
    lets its numbers grow while they are read ⇒ open(at('tables.bin'), 'wb').write(numbers() * 2); finish([moment(0) | {'contacts': 0}, moment(10) | {'contacts': 0}, end(10)]); grow('tables.bin', 'x') ⇒ tables.bin goes on after the last moment ⇒ 4
    lies about its progress ⇒ print('settle 99999999999999999999 nan\nload -1 7.5\nsettle 5 -inf'); well() ⇒ wrote ⇒ 0
    changes the scene in its folder ⇒ put('scene.json', '{}'); put('initial.csv', ''); put('job.json', ''); well() ⇒ wrote ⇒ 0
    changes the scene of the user ⇒ put('../scene.json', '{}'); well() ⇒ wrote ⇒ 0
    writes lines as another system does ⇒ finish([moment(0, given.replace('\n', '\r\n')), moment(10), end(10)]) ⇒ wrote ⇒ 0
    leaves processes behind ⇒ well(); os.fork() or time.sleep(600) ⇒ wrote ⇒ 0
"#;

/// Whether a process stays at work in this folder, or in one that was in it; one that was killed may take a moment to go.
fn is_at_work_in(folder: &Path) -> bool {
    let mut looks = (0..40).map(|_| {
        std::thread::sleep(Duration::from_millis(50));
        at_work_in(folder)
    });
    looks.all(|found| found > 0)
}

/// What is wrong with how it ends.
fn wrong(does: &str, sentence: &str, code: &str) -> Option<String> {
    let scene = scene_of(2);
    let folder = folder_with(&scene);
    let (say, run) = if does.starts_with("SAY") {
        (does, "")
    } else {
        ("", does)
    };
    let text = format!("{SOUND}{say}{AND_THEN}{TOOLS}{run}\n");
    let engine = engine(&folder, "engine.py", &text);
    // The program may have this memory; its engine takes more.
    let command = format!(
        "ulimit -S -v 500000 && exec timeout -s KILL 25 $0 run scene.json --engine {engine} --out out --steps 10 --stall-limit 4 --time-limit 8 \
         --memory-limit 300 --output-limit 8"
    );
    let began = Instant::now();
    let (ended, said, errors) = bash(&folder, &command, &[]);
    let took = began.elapsed();
    let left = there(&folder);
    let believed = match ended {
        0 => RunFolder::read(&folder.join("out")).is_ok_and(|run| run.scene == scene),
        _ => !folder.join("out/run.json").exists(),
    };
    let holds = ended.to_string() == code
        && (errors.contains(sentence) || said.contains(sentence))
        && !errors.contains("panicked")
        && errors.lines().count() < 20
        && took < Duration::from_secs(20)
        && !left.iter().any(|name| name.starts_with(".crossgrain"))
        && !is_at_work_in(&folder)
        && believed;
    let what = || {
        format!(
            "«{sentence}» with exit code {code}, and not in {took:?} exit code {ended}, {left:?}: {said}{errors}"
        )
    };
    (!holds).then(what)
}

#[test]
fn every_hostile_engine_ends_in_its_own_sentence() {
    let found = Mutex::new(Vec::new());
    // Most of the time they wait.
    let done = workers::each(rows(HOSTILE), 6, |[name, does, sentence, code]| {
        let what = wrong(does, sentence, code).map(|what| format!("{name}: {what}"));
        workers::lock(&found).push(what);
        Ok::<(), ()>(())
    });
    let found = found.into_inner().expect("no panic");
    assert!(done.is_ok() && found.len() > 90);
    let found: Vec<String> = found.into_iter().flatten().collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}
