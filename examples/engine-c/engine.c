/* A frictionless engine in C for small beds, to begin with: cc -O2 -ffp-contract=off -o engine engine.c -lm
   It looks at all pairs; a larger bed wants a grid. The protocol: docs/engine-protocol.md. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST 20000
#define WALLS 16

typedef struct { double x[2], v[2], radius, mass, force[2]; } Grain;
typedef struct { int axis; double place; } Wall;
typedef struct { int one, two; double overlap, fn, ft, n[2], x[2]; } Contact;

static Grain grain[MOST];
static Wall wall[WALLS];
static Contact contact[16 * MOST];
static int grains, walls, contacts;
static double modulus, alpha, dt, gravity[2];

static void fail(const char *why) { fprintf(stderr, "%s\n", why); exit(1); }

/* What stands behind a key, from here on. A real engine takes a JSON library. */
static const char *after(const char *from, const char *key) {
    char quoted[64];
    snprintf(quoted, sizeof quoted, "\"%s\"", key);
    const char *found = strstr(from, quoted);
    if (!found) return NULL;
    found += strlen(quoted);
    return found + strspn(found, ": \n\t");
}

static double number(const char *from, const char *key) {
    const char *at = after(from, key);
    if (!at) fail("a key is missing in job.json");
    return strtod(at, NULL);
}

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
    if (!model) fail("job.json has no model");
    alpha = number(model, "alpha");
    dt = number(model, "dt");
    modulus = number(model, "modulus");
    char *next;
    gravity[0] = strtod(after(model, "gravity") + 1, &next);
    gravity[1] = strtod(next + 1, NULL);
    const char *at = after(model, "walls"), *end = strchr(at, ']');
    for (walls = 0; (at = after(at, "axis")) && at < end; walls++) {
        if (walls == WALLS) fail("too many walls");
        wall[walls].axis = at[1] == 'z';
        wall[walls].place = number(at, "place");
    }
}

static void read_grains(const char *folder) {
    FILE *file = in_folder(folder, "initial.csv", "r");
    char line[1024];
    grains = -1; /* the heading */
    while (fgets(line, sizeof line, file)) {
        if (grains == MOST) fail("too many grains");
        Grain *of = &grain[grains];
        if (grains++ >= 0
            && sscanf(line, "%*d,%lf,%lf,%lf,%lf,%lf,%lf", &of->x[0], &of->x[1], &of->v[0], &of->v[1], &of->radius, &of->mass) != 6)
            fail("initial.csv cannot be read");
    }
    fclose(file);
}

/* A spring between body `one`, a grain or a wall, which bears nothing, and grain `two`. */
static void push(int one, int two, double overlap, double k, const double n[2], const double x[2]) {
    double f[2] = {k * overlap * n[0], k * overlap * n[1]};
    for (int axis = 0; axis < 2; axis++) {
        grain[two].force[axis] += f[axis];
        if (one < grains) grain[one].force[axis] -= f[axis];
    }
    if (contacts == 16 * MOST) fail("too many contacts");
    contact[contacts++] = (Contact){one, two, overlap, f[0] * n[0] + f[1] * n[1], f[1] * n[0] - f[0] * n[1], {n[0], n[1]}, {x[0], x[1]}};
}

/* Each pair once, in the order of their ids, then wall by wall. */
static void add_forces(void) {
    contacts = 0;
    for (int i = 0; i < grains; i++) grain[i].force[0] = grain[i].force[1] = 0.0;
    for (int i = 0; i < grains; i++)
        for (int j = i + 1; j < grains; j++) {
            double dx = grain[j].x[0] - grain[i].x[0], dz = grain[j].x[1] - grain[i].x[1];
            double distance = sqrt(dx * dx + dz * dz), overlap = grain[i].radius + grain[j].radius - distance;
            if (overlap < 0.0) continue;
            double a = modulus * grain[i].radius, b = modulus * grain[j].radius;
            double n[2] = {dx / distance, dz / distance}, arm = grain[i].radius - 0.5 * overlap;
            double x[2] = {grain[i].x[0] + arm * n[0], grain[i].x[1] + arm * n[1]};
            push(i, j, overlap, 2.0 * a * b / (a + b), n, x);
        }
    for (int index = 0; index < walls; index++)
        for (int j = 0; j < grains; j++) {
            int axis = wall[index].axis;
            double distance = grain[j].x[axis] - wall[index].place, overlap = grain[j].radius - fabs(distance);
            if (overlap < 0.0) continue;
            double a = modulus * grain[j].radius, n[2] = {0.0, 0.0}, x[2] = {grain[j].x[0], grain[j].x[1]};
            n[axis] = copysign(1.0, distance);
            x[axis] = wall[index].place;
            push(grains + index, j, overlap, 2.0 * a * a / (a + a), n, x);
        }
}

/* Leapfrog: velocities belong to the half step before the positions. */
static void move(void) {
    for (int i = 0; i < grains; i++)
        for (int axis = 0; axis < 2; axis++) {
            double a = grain[i].force[axis] / grain[i].mass + gravity[axis];
            double power = a * (grain[i].v[axis] + 0.5 * dt * a);
            a *= 1.0 - alpha * ((power > 0.0) - (power < 0.0));
            grain[i].v[axis] += dt * a;
            grain[i].x[axis] += dt * grain[i].v[axis];
        }
}

static void write_moment(const char *folder, long step) {
    char name[64];
    snprintf(name, sizeof name, "settle-%ld-bodies.csv", step);
    FILE *file = in_folder(folder, name, "w");
    fprintf(file, "id,x,z,vx,vz,radius,mass\n");
    for (int i = 0; i < grains; i++) {
        Grain *of = &grain[i];
        fprintf(file, "%d,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", i, of->x[0], of->x[1], of->v[0], of->v[1], of->radius, of->mass);
    }
    fclose(file);
    snprintf(name, sizeof name, "settle-%ld-contacts.csv", step);
    file = in_folder(folder, name, "w");
    fprintf(file, "id1,id2,overlap,fn,ft,nx,nz,x,z\n");
    for (int i = 0; i < contacts; i++) {
        Contact *of = &contact[i];
        fprintf(file, "%d,%d,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n",
                of->one, of->two, of->overlap, of->fn, of->ft, of->n[0], of->n[1], of->x[0], of->x[1]);
    }
    fclose(file);
    file = in_folder(folder, "moments.jsonl", "a");
    fprintf(file, "{\"stage\": \"settle\", \"step\": %ld}\n", step);
    fclose(file);
}

/* Whether a case asks for this step. */
static int asks(const char *job, long step) {
    char *at = (char *)after(job, "moments") + 1;
    for (; *at && *at != ']'; at += strspn(at, ", \n\t"))
        if (strtol(at, &at, 10) == step) return 1;
    return 0;
}

static long run(const char *folder) {
    char *job = read_job(folder), *at;
    if (!strncmp(after(job, "kind"), "\"cases\"", 7)) {
        long steps = 0;
        const char *name = after(job, "folders"), *end = strchr(name, ']');
        while ((name = strchr(name, '"')) && name++ < end) {
            char inner[4096];
            int length = (int)strcspn(name, "\"");
            snprintf(inner, sizeof inner, "%s/%.*s", folder, length, name);
            steps += run(inner);
            name += length + 1;
        }
        free(job);
        return steps;
    }
    int is_scene = !strncmp(after(job, "kind"), "\"scene\"", 7);
    long first = is_scene ? (long)number(job, "step") : 0, last = first, every = is_scene ? (long)number(job, "moments_every") : 0;
    if (is_scene) last = (long)number(job, "until_step");
    else for (at = (char *)after(job, "moments") + 1; *at != ']'; at += strspn(at, ", \n\t")) last = strtol(at, &at, 10);
    read_model(job);
    read_grains(folder);
    for (long step = first; step <= last; step++) {
        if (step > first) move();
        add_forces();
        int shown = is_scene ? step == first || step == last || step % every == 0 : asks(job, step);
        if (shown) write_moment(folder, step);
        if (step % 100 == 0) { printf("settle %ld\n", step); fflush(stdout); }
    }
    if (is_scene) {
        FILE *file = in_folder(folder, "moments.jsonl", "a");
        fprintf(file, "{\"end\": \"settle\", \"steps\": %ld, \"stop\": \"steps_done\", \"wall_seconds\": 0.0, \"cpu_seconds\": 0.0}\n", last);
        fclose(file);
    }
    free(job);
    return last - first;
}

int main(int count, char **word) {
    if (count == 2 && !strcmp(word[1], "describe")) {
        puts("{\"protocol\": 1, \"name\": \"engine-c\", \"version\": \"1\", \"parts\": "
             "[\"normal_spring\", \"local_damping\", \"gravity\", \"walls\", \"cases\"]}");
        return 0;
    }
    if (count != 3 || strcmp(word[1], "run")) fail("usage: engine describe | run FOLDER");
    long steps = run(word[2]);
    FILE *file = in_folder(word[2], "done.json", "w");
    fprintf(file, "{\"steps\": %ld}\n", steps);
    fclose(file);
    return 0;
}
