/* An engine with a contact law of its own: cohesive discs whose slip is braked. cc -O2 -ffp-contract=off -o engine engine.c -lm
   A pair pulls until it is pressed by COHESION of the smaller radius; the tangential force is a dashpot that Coulomb limits.
   No reference has this law, so crossgrain holds the engine against itself. The protocol: docs/engine-protocol.md. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST 20000
#define WALLS 16
#define CELLS 64
#define COHESION 2e-5
#define BRAKE 0.3

typedef struct { double x[2], v[2], radius, mass, spin, inertia, force[2], torque; int next; } Grain;
typedef struct { int axis; double place; } Wall;
typedef struct { int one, two; double overlap, fn, ft, n[2], x[2]; } Contact;

static Grain grain[MOST];
static Wall wall[WALLS];
static Contact contact[16 * MOST];
static int grains, walls, contacts, turns, first_in[CELLS * CELLS];
static double modulus, friction, alpha, dt, gravity[2];

static void fail(const char *why) { fprintf(stderr, "%s\n", why); exit(1); }

/* What stands behind a key, from here on. A real engine takes a JSON library. */
static char *after(const char *from, const char *key) {
    char quoted[64];
    snprintf(quoted, sizeof quoted, "\"%s\"", key);
    char *found = strstr(from, quoted);
    if (!found) fail(key);
    found += strlen(quoted);
    return found + strspn(found, ": \n\t");
}

static double number(const char *from, const char *key) { return strtod(after(from, key), NULL); }

static FILE *in_folder(const char *folder, const char *name, const char *mode) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, mode);
    if (!file) fail(path);
    return file;
}

static char *read_job(const char *folder) {
    FILE *file = in_folder(folder, "job.json", "rb");
    char *text = calloc(1, 1 << 20);
    if (!text || fread(text, 1, (1 << 20) - 1, file) == 0) fail("job.json cannot be read");
    fclose(file);
    return text;
}

static void read_model(const char *job) {
    const char *model = after(job, "model");
    alpha = number(model, "alpha");
    dt = number(model, "dt");
    modulus = number(model, "modulus");
    friction = tan(number(model, "friction_angle"));
    char *next;
    gravity[0] = strtod(after(model, "gravity") + 1, &next);
    gravity[1] = strtod(next + 1, NULL);
    const char *at = after(model, "walls"), *end = strchr(at, ']');
    for (walls = 0; (at = strstr(at, "\"axis\"")) && at < end; walls++) {
        if (walls == WALLS) fail("too many walls");
        wall[walls].axis = after(at, "axis")[1] == 'z';
        wall[walls].place = number(at, "place");
        at++;
    }
}

static void read_grains(const char *folder) {
    FILE *file = in_folder(folder, "initial.csv", "r");
    char line[1024];
    turns = fgets(line, sizeof line, file) && strstr(line, "spin");
    for (grains = 0; fgets(line, sizeof line, file); grains++) {
        if (grains == MOST) fail("too many grains");
        Grain *g = &grain[grains];
        g->spin = 0.0, g->inertia = 1.0;
        if (sscanf(line, "%*d,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf", &g->x[0], &g->x[1], &g->v[0], &g->v[1], &g->radius, &g->mass,
                   &g->spin, &g->inertia) < 6)
            fail("initial.csv cannot be read");
    }
    fclose(file);
}

/* The law, of body `one`, a grain or a wall, which bears nothing, and grain `two`: `r` is the smaller radius, `m` the mass that
   moves, and the arms reach from the centres to the point `x`. */
static void touch(int one, int two, double overlap, double r, double m, const double n[2], const double x[2], const double arm[2]) {
    Grain still = {0}, *a = one < grains ? &grain[one] : &still, *b = &grain[two];
    double k = modulus * r, fn = k * (overlap - COHESION * r);
    double slip = (b->v[1] - a->v[1]) * n[0] - (b->v[0] - a->v[0]) * n[1] + arm[0] * a->spin + arm[1] * b->spin;
    double most = friction * k * overlap, ft = -BRAKE * sqrt(k * m) * slip;
    if (ft > most) ft = most;
    if (ft < -most) ft = -most;
    double f[2] = {fn * n[0] - ft * n[1], fn * n[1] + ft * n[0]};
    for (int axis = 0; axis < 2; axis++) {
        b->force[axis] += f[axis];
        a->force[axis] -= f[axis];
    }
    a->torque += arm[0] * ft;
    b->torque += arm[1] * ft;
    if (contacts == 16 * MOST) fail("too many contacts");
    contact[contacts++] = (Contact){one, two, overlap, fn, ft, {n[0], n[1]}, {x[0], x[1]}};
}

static void pair(int i, int j) {
    Grain *a = &grain[i], *b = &grain[j];
    double dx = b->x[0] - a->x[0], dz = b->x[1] - a->x[1];
    double distance = sqrt(dx * dx + dz * dz), overlap = a->radius + b->radius - distance;
    if (overlap < 0.0) return;
    double n[2] = {dx / distance, dz / distance}, arm[2] = {a->radius - 0.5 * overlap, b->radius - 0.5 * overlap};
    double x[2] = {a->x[0] + arm[0] * n[0], a->x[1] + arm[0] * n[1]};
    touch(i, j, overlap, fmin(a->radius, b->radius), a->mass * b->mass / (a->mass + b->mass), n, x, arm);
}

static int by_ids(const void *a, const void *b) {
    const Contact *one = a, *two = b;
    return one->one != two->one ? one->one - two->one : one->two - two->two;
}

/* Grains are sorted into cells as wide as the largest one, which repeat after CELLS of them in each direction. */
static void add_forces(void) {
    double width = 0.0;
    contacts = 0;
    memset(first_in, -1, sizeof first_in);
    for (int i = 0; i < grains; i++) width = fmax(width, 2.0 * grain[i].radius);
    for (int i = 0; i < grains; i++) {
        Grain *g = &grain[i];
        g->force[0] = g->force[1] = g->torque = 0.0;
    }
    for (int i = 0; i < grains; i++) {
        int column = (int)floor(grain[i].x[0] / width), row = (int)floor(grain[i].x[1] / width);
        for (int beside = -1; beside <= 1; beside++)
            for (int above = -1; above <= 1; above++) {
                int cell = ((column + beside) & (CELLS - 1)) * CELLS + ((row + above) & (CELLS - 1));
                for (int j = first_in[cell]; j >= 0; j = grain[j].next) pair(j, i);
            }
        int own = (column & (CELLS - 1)) * CELLS + (row & (CELLS - 1));
        grain[i].next = first_in[own];
        first_in[own] = i;
    }
    for (int index = 0; index < walls; index++)
        for (int j = 0; j < grains; j++) {
            int axis = wall[index].axis;
            Grain *g = &grain[j];
            double distance = g->x[axis] - wall[index].place, overlap = g->radius - fabs(distance);
            if (overlap < 0.0) continue;
            double n[2] = {0.0, 0.0}, x[2] = {g->x[0], g->x[1]}, arm[2] = {0.0, g->radius - overlap};
            n[axis] = copysign(1.0, distance);
            x[axis] = wall[index].place;
            touch(grains + index, j, overlap, g->radius, g->mass, n, x, arm);
        }
    qsort(contact, contacts, sizeof *contact, by_ids);
}

/* Leapfrog with Cundall's damping: velocities belong to the half step before the positions. */
static double damped(double a, double v) {
    double power = a * (v + 0.5 * dt * a);
    return a * (1.0 - alpha * ((power > 0.0) - (power < 0.0)));
}

static void move(void) {
    for (int i = 0; i < grains; i++) {
        Grain *g = &grain[i];
        for (int axis = 0; axis < 2; axis++) {
            g->v[axis] += dt * damped(g->force[axis] / g->mass + gravity[axis], g->v[axis]);
            g->x[axis] += dt * g->v[axis];
        }
        if (turns) g->spin += dt * damped(g->torque / g->inertia, g->spin);
    }
}

static void write_moment(const char *folder, long step) {
    char name[64];
    snprintf(name, sizeof name, "settle-%ld-bodies.csv", step);
    FILE *file = in_folder(folder, name, "w");
    fprintf(file, "id,x,z,vx,vz,radius,mass%s\n", turns ? ",spin,inertia" : "");
    for (int i = 0; i < grains; i++) {
        Grain *g = &grain[i];
        fprintf(file, "%d,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g", i, g->x[0], g->x[1], g->v[0], g->v[1], g->radius, g->mass);
        if (turns) fprintf(file, ",%.17g,%.17g", g->spin, g->inertia);
        fprintf(file, "\n");
    }
    fclose(file);
    snprintf(name, sizeof name, "settle-%ld-contacts.csv", step);
    file = in_folder(folder, name, "w");
    fprintf(file, "id1,id2,overlap,fn,ft,nx,nz,x,z\n");
    for (int i = 0; i < contacts; i++) {
        Contact *c = &contact[i];
        fprintf(file, "%d,%d,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", c->one, c->two, c->overlap, c->fn, c->ft, c->n[0], c->n[1],
                c->x[0], c->x[1]);
    }
    fclose(file);
    file = in_folder(folder, "moments.jsonl", "a");
    fprintf(file, "{\"stage\": \"settle\", \"step\": %ld}\n", step);
    fclose(file);
}

/* The steps of a list of cases, or of one. */
static long run(const char *folder) {
    char *job = read_job(folder), inner[4096];
    long steps = 0;
    if (!strncmp(after(job, "kind"), "\"cases\"", 7)) {
        const char *name = after(job, "folders"), *end = strchr(name, ']');
        while ((name = strchr(name, '"')) && name++ < end) {
            int length = (int)strcspn(name, "\"");
            snprintf(inner, sizeof inner, "%s/%.*s", folder, length, name);
            steps += run(inner);
            name += length + 1;
        }
    } else {
        read_model(job);
        read_grains(folder);
        add_forces();
        for (char *at = after(job, "moments") + 1; *at != ']'; at += strspn(at, ", \n\t")) {
            for (long moment = strtol(at, &at, 10); steps < moment; steps++) {
                move();
                add_forces();
            }
            write_moment(folder, steps);
        }
    }
    free(job);
    return steps;
}

int main(int count, char **word) {
    if (count == 2 && !strcmp(word[1], "describe")) {
        puts("{\"protocol\": 1, \"name\": \"cohesive discs\", \"version\": \"1\", \"own_law\": [], \"parts\": [\"normal_spring\", "
             "\"tangential_spring\", \"rotation\", \"local_damping\", \"gravity\", \"walls\", \"cases\"]}");
        return 0;
    }
    if (count != 3 || strcmp(word[1], "run")) fail("usage: engine describe | run FOLDER");
    long steps = run(word[2]);
    FILE *file = in_folder(word[2], "done.json", "w");
    fprintf(file, "{\"steps\": %ld}\n", steps);
    fclose(file);
    return 0;
}
