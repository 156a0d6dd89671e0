/* A discrete-element engine in plain C for the engine protocol, version 1. It has all parts but timing.
   Build: cc -O2 -std=c11 -o engine engine.c -lm
   The program is right unless a switch is set. A switch is set by the file name of the program, as in
   a copy or a hard link engine--gravity-hard-coded, or at compile time by -DFAULT=gravity_hard_coded.
   A symbolic link will not do, for crossgrain starts the file that it points to. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include <time.h>

#ifndef REAL
#define REAL double /* The type of positions, velocities and sums. */
#endif
#ifndef FORCE_REAL
#define FORCE_REAL REAL /* The type in which the contact law is computed. */
#endif
typedef REAL real;
typedef FORCE_REAL freal;

/* All switches. Those of the first list are faults, those of the second are right. */
#define FAULTS(X) \
    X(gravity_hard_coded) X(gravity_x_ignored) X(gravity_standard_value) X(alpha_hard_coded) \
    X(alpha_three_tenths) X(alpha_old_velocity) X(alpha_spares_gravity) X(alpha_spares_spin) X(dt_rounded) \
    X(modulus_hard_coded) X(ratio_ignored) X(friction_angle_hard_coded) X(friction_angle_as_coefficient) \
    X(wall_friction_ignored) X(punch_friction_is_walls) X(rotation_always_free) X(rotation_always_blocked) \
    X(slip_always_corrected) X(slip_never_corrected) X(slip_without_stretch) X(arms_always_half_overlap) \
    X(arms_whole_radius) X(new_slip_whole_step) X(tension_always_clipped) X(tension_always_unclipped) \
    X(restitution_as_ratio) X(restitution_closed_formula) X(restitution_whole_mass) X(dashpot_ignored) \
    X(loading_model_ignored) X(loading_forgets_shear) X(punch_speed_hard_coded) X(punch_width_hard_coded) \
    X(punch_without_corners) X(wall_places_as_floats) X(first_wall_at_zero) X(wall_one_sided) X(floor_raised) \
    X(wall_stiffness_halved) X(fn_too_large) X(fn_zero) X(ft_zero) X(ft_sign) X(normals_flipped) \
    X(points_off) X(overlaps_doubled) X(half_contacts_missing) X(contacts_invented) X(contacts_one_step_old) \
    X(wall_contacts_missing) X(wall_ids_swapped) X(velocities_full_step) X(spin_sign_written) \
    X(eight_digits_written) X(stiffer_after_100) X(friction_lost_after_200) X(ids_beyond_500) \
    X(large_beds_only) X(scenes_only) X(cases_only_fault) X(fast_grains_only) X(deep_overlaps_only) \
    X(beside_walls_only) X(search_too_rare) X(history_lost_at_rebuild) X(load_stage_only) \
    X(stiffness_arithmetic_mean) X(mass_recomputed) X(inertia_of_spheres) X(stiffness_tiny_error) \
    X(start_rounded) X(shear_not_turned) X(limit_not_remembered) X(explicit_euler) X(reaction_incomplete) \
    X(coarse_moments_only) X(last_grain_without_pairs) X(torque_only_second) X(limit_from_spring_alone) \
    X(settle_ten_times) X(settle_without_peak) X(load_half_target) X(standing_still_ignored) \
    X(punch_starts_highest_of_all) X(punch_force_over_reported) X(shear_lost_every_1000) \
    X(wall_friction_lost_after_3000) X(velocities_full_step_after_3000) \
    X(settle_without_spins) X(punch_starts_by_centres) X(arms_follow_slip) \
    X(zero_at_walls_is_unset) X(friction_capped) X(blocked_without_dashpots) \
    X(loading_punch_friction_ignored) \
    X(weightless_while_standing)
#define RIGHTS(X) \
    X(pairs_reversed) X(walls_first) X(sums_shuffled) X(sweep_search) X(all_pairs_search) X(reciprocals) \
    X(with_hypot) X(momenta) X(scaled_units) X(degrees) X(mirrored) X(origin_shifted) X(compensated_sums) \
    X(no_dashpots) X(no_friction) X(no_punch) X(only_cases) X(no_stop_rules) X(binary_tables) X(with_loads) X(unit_normals)
#define NAME(n) F_##n,
#define TEXT(n) #n,
enum { F_none, FAULTS(NAME) RIGHTS(NAME) F_count };
static const char *const switch_names[] = {"none", FAULTS(TEXT) RIGHTS(TEXT)};
#ifdef FAULT
#define PASTE(n) F_##n
#define PASTED(n) PASTE(n)
static int fault = PASTED(FAULT);
#else
static int fault = F_none;
#endif
#define IS(n) (fault == F_##n)

/* ---- Small helpers ---- */

static void fail(const char *why) {
    fprintf(stderr, "engine: %s\n", why);
    exit(1);
}

static void *memory_for(size_t count, size_t size) {
    void *at = calloc(count ? count : 1, size);
    if (!at) fail("no memory");
    return at;
}

static double seconds_now(void) {
    struct timespec t;
    timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static FILE *open_in(const char *folder, const char *name, const char *mode) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, mode);
    if (!file) fail("a file cannot be opened");
    return file;
}

static double rounded_to(double value, int digits) {
    char text[64];
    snprintf(text, sizeof text, "%.*e", digits - 1, value);
    return strtod(text, NULL);
}

/* ---- A tiny JSON reader: it keeps a tree of values ---- */

typedef struct Json {
    enum { J_NULL, J_FALSE, J_TRUE, J_NUMBER, J_TEXT, J_LIST, J_OBJECT } kind;
    char *key, *text;
    double number;
    struct Json *child, *next;
} Json;

static const char *json_at;

static void skip_blanks(void) { json_at += strspn(json_at, " \t\r\n"); }

static char *read_text(void) {
    const char *from = ++json_at;
    while (*json_at && *json_at != '"') json_at += json_at[0] == '\\' && json_at[1] ? 2 : 1;
    size_t length = (size_t)(json_at - from);
    char *text = memory_for(length + 1, 1);
    memcpy(text, from, length); /* Escapes stay as they are; no key that matters here has one. */
    if (*json_at++ != '"') fail("bad JSON: a text without end");
    return text;
}

static Json *read_value(void) {
    Json *value = memory_for(1, sizeof *value);
    skip_blanks();
    char c = *json_at;
    if (c == '{' || c == '[') {
        char close = c == '{' ? '}' : ']';
        Json **last = &value->child;
        value->kind = c == '{' ? J_OBJECT : J_LIST;
        json_at++;
        for (skip_blanks(); *json_at != close; skip_blanks()) {
            char *key = NULL;
            if (c == '{') {
                if (*json_at != '"') fail("bad JSON: no key");
                key = read_text();
                skip_blanks();
                if (*json_at++ != ':') fail("bad JSON: no colon");
            }
            *last = read_value();
            (*last)->key = key;
            last = &(*last)->next;
            skip_blanks();
            if (*json_at == ',') json_at++;
            else if (*json_at != close) fail("bad JSON: no comma");
        }
        json_at++;
    } else if (c == '"') {
        value->kind = J_TEXT;
        value->text = read_text();
    } else if (!strncmp(json_at, "null", 4)) {
        json_at += 4;
    } else if (!strncmp(json_at, "true", 4)) {
        value->kind = J_TRUE;
        json_at += 4;
    } else if (!strncmp(json_at, "false", 5)) {
        value->kind = J_FALSE;
        json_at += 5;
    } else {
        char *end;
        value->kind = J_NUMBER;
        value->number = strtod(json_at, &end);
        if (end == json_at) fail("bad JSON: not a value");
        json_at = end;
    }
    return value;
}

static Json *read_json(const char *folder, const char *name) {
    FILE *file = open_in(folder, name, "rb");
    size_t size = 0, room = 1 << 16;
    char *text = memory_for(room + 1, 1);
    for (size_t got; (got = fread(text + size, 1, room - size, file)) > 0;) {
        size += got;
        if (size == room) {
            room *= 2;
            text = realloc(text, room + 1);
            if (!text) fail("no memory");
        }
    }
    text[size] = 0;
    fclose(file);
    json_at = text;
    Json *value = read_value();
    free(text);
    return value;
}

/* The value behind a key, or NULL if it is not there or null. */
static const Json *get(const Json *of, const char *key) {
    if (of && of->kind == J_OBJECT)
        for (const Json *at = of->child; at; at = at->next)
            if (!strcmp(at->key, key)) return at->kind == J_NULL ? NULL : at;
    return NULL;
}

static double number(const Json *of, const char *key) {
    const Json *at = get(of, key);
    if (!at || at->kind != J_NUMBER) {
        fprintf(stderr, "engine: the number %s is missing in job.json\n", key);
        exit(1);
    }
    return at->number;
}

static double number_or(const Json *of, const char *key, double otherwise) {
    return get(of, key) ? number(of, key) : otherwise;
}

static int is_text(const Json *of, const char *key, const char *text) {
    const Json *at = get(of, key);
    return at && at->kind == J_TEXT && !strcmp(at->text, text);
}

static int is_true(const Json *of, const char *key) {
    const Json *at = get(of, key);
    return at && at->kind == J_TRUE;
}

/* ---- The model and the bed ---- */

#define MOST_WALLS 32
enum { GRAINS, WALL, PUNCH_OUTSIDE, PUNCH_INSIDE };

typedef struct {
    real gravity[2], alpha, dt, modulus, ratio, tan2[3];
    int walls, axis[MOST_WALLS];
    real place[MOST_WALLS];
    int friction, rotates, dashpots, restitution, clipped, corrected, half_arms, since_touch;
    real c_n, zeta;
} Model;

typedef struct { freal n[2], s[2]; } Memory; /* The last normal and the shear force on body 2. */
typedef struct { int one, two; double overlap, fn, ft, n[2], p[2]; } Contact;
typedef struct { real u, n[2], p[2], r1, r2; int kind; } Touch;

static Model model;
static int N, has_spin, in_case, in_load, coarse;
static long job_step; /* Steps since the start of this job. */
static real *x[2], *v[2], *w, *radius, *mass, *inertia, *f[2], *torque, *lost[2];
static double *raw[7]; /* The start as it was given: x, z, vx, vz, radius, mass, spin. */
static double *raw_inertia;
static char *near_wall;
static struct { int there; real c[2], h[2], start, velocity, force; } punch;

static Contact *contacts, *old_contacts;
static int contact_count, contact_room, old_count, recording;

/* Units inside: lengths, masses and times are multiplied by these; x may also be mirrored. */
static real unit_x[2] = {1, 1}, origin[2], unit_length = 1, unit_mass = 1, unit_time = 1, mirror = 1;

/* Verlet list: the partners of grain i with larger ids, and what each contact remembers. */
static int *row, *partner, list_there;
static Memory *pair_memory, *wall_memory, *punch_memory;
static real *listed[2], skin;
static long listed_at;

static double clipped_restitution(double zeta) {
    double off = 1.0 - zeta * zeta;
    if (fabs(off) < 1e-12) return exp(-2.0);
    double s = sqrt(fabs(off));
    double angle = off > 0 ? 3.14159265358979323846 - atan2(2 * zeta * s, 1 - 2 * zeta * zeta) : 2 * log(zeta + s);
    return exp(-(zeta / s) * angle);
}

/* The damping ratio that gives the restitution e. */
static double damping_ratio(double e, int clipped) {
    double l = -log(e), low = l / sqrt(9.86960440108935861883 + l * l), high = 1;
    if (IS(restitution_as_ratio)) return e;
    if (!clipped || e == 1.0 || IS(restitution_closed_formula)) return low;
    while (clipped_restitution(high) > e) high *= 2;
    for (int i = 0; i < 200; i++) {
        double middle = 0.5 * (low + high);
        if (clipped_restitution(middle) > e) low = middle;
        else high = middle;
    }
    return 0.5 * (low + high);
}

static void read_model(const Json *from) {
    if (!from) fail("job.json has no model");
    const Json *law = get(from, "law"), *contact = get(law, "contact"), *viscosity = get(contact, "viscosity");
    const Json *g = get(from, "gravity");
    Model *m = &model;
    memset(m, 0, sizeof *m);
    if (!law || !contact || !g || !g->child || !g->child->next) fail("the model is not complete");
    double gx = g->child->number, gz = g->child->next->number;
    if (IS(gravity_hard_coded) && gz != 0) gz = -9.81;
    if (IS(gravity_x_ignored)) gx = 0;
    if (IS(gravity_standard_value)) gz *= 9.80665 / 9.81;
    real per_time2 = 1 / (unit_time * unit_time);
    m->gravity[0] = (real)gx * unit_x[0] * per_time2;
    m->gravity[1] = (real)gz * unit_x[1] * per_time2;
    m->alpha = number(from, "alpha");
    if (IS(alpha_hard_coded) && m->alpha != 0) m->alpha = (real)0.2;
    if (IS(alpha_three_tenths)) m->alpha = (real)0.3;
    double dt = number(from, "dt");
    if (IS(dt_rounded)) dt = rounded_to(dt, 2);
    m->dt = (real)dt * unit_time;
    for (const Json *at = get(from, "walls") ? get(from, "walls")->child : NULL; at; at = at->next) {
        if (m->walls == MOST_WALLS) fail("too many walls");
        int axis = m->axis[m->walls] = is_text(at, "axis", "z");
        double place = number(at, "place");
        if (IS(wall_places_as_floats)) place = (float)place;
        if (IS(first_wall_at_zero) && m->walls == 0) place = 0;
        if (IS(floor_raised) && axis == 1) place += 1e-7;
        m->place[m->walls++] = ((real)place - origin[axis]) * unit_x[axis];
    }
    double modulus = number(law, "modulus");
    if (IS(modulus_hard_coded)) modulus = 1e10;
    m->modulus = (real)modulus * unit_mass * per_time2 / unit_length;
    m->ratio = number(law, "stiffness_ratio");
    if (IS(ratio_ignored)) m->ratio = 1;
    double angle[3];
    angle[0] = number(law, "friction_angle");
    if (IS(friction_angle_hard_coded) && angle[0] > 0) angle[0] = 0.5;
    angle[1] = number_or(law, "wall_friction_angle", angle[0]);
    angle[2] = number_or(law, "punch_friction_angle", angle[0]);
    if (IS(wall_friction_ignored)) angle[1] = angle[0];
    if (IS(punch_friction_is_walls)) angle[2] = angle[1];
    if (IS(zero_at_walls_is_unset) && angle[1] == 0) angle[1] = angle[0];
    if (IS(loading_punch_friction_ignored) && in_load) angle[2] = angle[0];
    if (IS(friction_capped) && angle[0] > 0.8) angle[0] = 0.8;
    for (int i = 0; i < 3; i++) {
        m->friction |= angle[i] > 0;
        real tangent = tan((real)angle[i]);
        if (IS(friction_angle_as_coefficient)) tangent = angle[i];
        if (IS(degrees)) {
            const real half_turn = (real)3.14159265358979323846L;
            real in_degrees = (real)angle[i] * (180 / half_turn);
            tangent = sin(in_degrees * half_turn / 180) / cos(in_degrees * half_turn / 180);
        }
        m->tan2[i] = tangent * tangent;
    }
    int is_free = is_text(contact, "rotation", "free");
    if (IS(rotation_always_free)) is_free = 1;
    if (IS(rotation_always_blocked)) is_free = 0;
    m->rotates = m->friction && is_free && (has_spin || IS(rotation_always_free));
    m->dashpots = !is_text(viscosity, "kind", "none") && !IS(dashpot_ignored);
    m->clipped = !is_text(viscosity, "tension", "unclipped");
    if (IS(tension_always_clipped)) m->clipped = 1;
    if (IS(tension_always_unclipped)) m->clipped = 0;
    if (is_text(viscosity, "kind", "dashpot")) m->c_n = (real)number(viscosity, "c_n") * unit_mass / unit_time;
    if (is_text(viscosity, "kind", "restitution")) {
        m->restitution = 1;
        m->zeta = damping_ratio(number(viscosity, "e_n"), m->clipped);
    }
    m->corrected = !is_text(contact, "slip_velocity", "contact_point");
    if (IS(slip_always_corrected)) m->corrected = 1;
    if (IS(slip_never_corrected)) m->corrected = 0;
    if (IS(blocked_without_dashpots) && m->friction && !is_free) m->dashpots = 0;
    m->half_arms = !is_text(contact, "torque_arms", "contact_point") || IS(arms_always_half_overlap);
    if (IS(arms_follow_slip)) m->half_arms = m->corrected;
    m->since_touch = is_text(contact, "new_contact_slip", "since_touch") && !IS(new_slip_whole_step);
}

static void forget_bed(void) {
    void *all[] = {x[0], x[1], v[0], v[1], w, radius, mass, inertia, f[0], f[1], torque, lost[0], lost[1], raw[0], raw[1],
                   raw[2], raw[3], raw[4], raw[5], raw[6], raw_inertia, near_wall, row, partner, pair_memory, wall_memory,
                   punch_memory, listed[0], listed[1]};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) free(all[i]);
    partner = NULL;
    pair_memory = NULL;
}

static void read_grains(const char *folder) {
    FILE *file = open_in(folder, "initial.csv", "r");
    char line[1024];
    static int filled;
    if (filled) forget_bed();
    filled = 1;
    if (!fgets(line, sizeof line, file)) fail("initial.csv is empty");
    has_spin = strstr(line, "spin") != NULL;
    for (N = 0; fgets(line, sizeof line, file);) N += line[0] >= '0' && line[0] <= '9';
    size_t n = (size_t)N;
    for (int a = 0; a < 2; a++) {
        x[a] = memory_for(n, sizeof(real));
        v[a] = memory_for(n, sizeof(real));
        f[a] = memory_for(n, sizeof(real));
        lost[a] = memory_for(n, sizeof(real));
        listed[a] = memory_for(n, sizeof(real));
    }
    for (int a = 0; a < 7; a++) raw[a] = memory_for(n, sizeof(double));
    raw_inertia = memory_for(n, sizeof(double));
    w = memory_for(n, sizeof(real));
    radius = memory_for(n, sizeof(real));
    mass = memory_for(n, sizeof(real));
    inertia = memory_for(n, sizeof(real));
    torque = memory_for(n, sizeof(real));
    near_wall = memory_for(n, 1);
    row = memory_for(n + 2, sizeof(int));
    wall_memory = memory_for(n * MOST_WALLS, sizeof(Memory));
    punch_memory = memory_for(n, sizeof(Memory));
    list_there = 0;
    rewind(file);
    if (!fgets(line, sizeof line, file)) fail("initial.csv is empty");
    for (int i = 0; i < N && fgets(line, sizeof line, file); i++) {
        char *at = line;
        double value[9] = {0};
        for (int column = 0; column < (has_spin ? 9 : 7); column++) {
            char *end;
            value[column] = strtod(at, &end);
            if (end == at) fail("initial.csv cannot be read");
            at = end + (*end == ',');
        }
        for (int a = 0; a < 7; a++) raw[a][i] = value[a + 1];
        raw_inertia[i] = value[8];
        if (IS(start_rounded))
            for (int a = 1; a < 8; a++) value[a] = a < 5 || a == 7 ? rounded_to(value[a], 6) : value[a];
        radius[i] = (real)value[5] * unit_length;
        mass[i] = (real)value[6] * unit_mass;
        if (IS(mass_recomputed)) mass[i] = (real)(2600.0 * 3.1416 * value[5] * value[5]);
        inertia[i] = (real)value[8] * unit_mass * unit_length * unit_length;
        if (!has_spin) inertia[i] = (real)0.5 * mass[i] * radius[i] * radius[i];
        if (IS(inertia_of_spheres)) inertia[i] = (real)0.4 * mass[i] * radius[i] * radius[i];
        for (int a = 0; a < 2; a++) {
            x[a][i] = ((real)value[1 + a] - origin[a]) * unit_x[a];
            v[a][i] = (real)value[3 + a] * unit_x[a] / unit_time;
            if (IS(momenta)) v[a][i] *= mass[i];
        }
        w[i] = (real)value[7] * mirror / unit_time;
    }
    fclose(file);
}

/* ---- Which pairs are near ---- */

static int too_far(void) {
    real most = 0;
    if (IS(search_too_rare)) return job_step - listed_at >= 25;
    for (int i = 0; i < N; i++) {
        real dx = x[0][i] - listed[0][i], dz = x[1][i] - listed[1][i], d = dx * dx + dz * dz;
        if (!(d <= most)) most = d;
    }
    return !(4 * most <= (real)0.98 * skin * skin);
}

static Memory remembered(const int *old_row, const int *old_partner, const Memory *old, int i, int j) {
    Memory none = {{0, 0}, {0, 0}};
    if (!old_partner || IS(history_lost_at_rebuild)) return none;
    for (int at = old_row[i]; at < old_row[i + 1]; at++)
        if (old_partner[at] == j) return old[at];
    return none;
}

static int by_number(const void *a, const void *b) { return *(const int *)a - *(const int *)b; }

static int found_count, found_room;
static int *found;

static void look_at(int i, int j) {
    real dx = x[0][j] - x[0][i], dz = x[1][j] - x[1][i], reach = radius[i] + radius[j] + skin;
    if (j <= i || dx * dx + dz * dz > reach * reach) return;
    if (found_count == found_room) {
        found_room = found_room ? 2 * found_room : 1024;
        found = realloc(found, sizeof(int) * (size_t)found_room);
        if (!found) fail("no memory");
    }
    found[found_count++] = j;
}

static const real *sort_by;
static int by_place(const void *a, const void *b) {
    real p = sort_by[*(const int *)a], q = sort_by[*(const int *)b];
    return (p > q) - (p < q);
}

static void build_list(void) {
    int *old_row = row, *old_partner = list_there ? partner : NULL, *old_block = partner;
    Memory *old = pair_memory;
    real largest = 0, low[2] = {0, 0}, high[2] = {0, 0};
    for (int i = 0; i < N; i++) {
        if (!(fabs(x[0][i]) < 1e30) || !(fabs(x[1][i]) < 1e30)) fail("a grain is lost");
        largest = radius[i] > largest ? radius[i] : largest;
        for (int a = 0; a < 2; a++) {
            low[a] = i && low[a] < x[a][i] ? low[a] : x[a][i];
            high[a] = i && high[a] > x[a][i] ? high[a] : x[a][i];
        }
    }
    skin = (real)0.4 * largest;
    if (IS(search_too_rare)) skin = (real)0.2 * largest;
    row = memory_for((size_t)N + 2, sizeof(int));
    found_count = 0;
    real size = 2 * largest + skin;
    int nx = 1, nz = 1;
    if (size > 0) {
        while ((high[0] - low[0]) / size * ((high[1] - low[1]) / size) > 8 * (real)N + 64) size *= 2;
        while ((high[0] - low[0]) / size + (high[1] - low[1]) / size > 8 * (real)N + 64) size *= 2;
        nx = (int)((high[0] - low[0]) / size) + 1;
        nz = (int)((high[1] - low[1]) / size) + 1;
    }
    int *head = memory_for((size_t)nx * (size_t)nz, sizeof(int)), *next = memory_for((size_t)N, sizeof(int));
    int *cell_x = memory_for((size_t)N, sizeof(int)), *cell_z = memory_for((size_t)N, sizeof(int));
    int *order = memory_for((size_t)N, sizeof(int)), *rank = memory_for((size_t)N, sizeof(int));
    for (int i = N - 1; i >= 0; i--) {
        cell_x[i] = size > 0 ? (int)((x[0][i] - low[0]) / size) : 0;
        cell_z[i] = size > 0 ? (int)((x[1][i] - low[1]) / size) : 0;
        int cell = cell_z[i] * nx + cell_x[i];
        next[i] = head[cell]; /* Grain i is kept as i + 1; 0 means none. */
        head[cell] = i + 1;
        order[i] = i;
    }
    if (IS(sweep_search)) {
        sort_by = x[0];
        qsort(order, (size_t)N, sizeof(int), by_place);
        for (int k = 0; k < N; k++) rank[order[k]] = k;
    }
    for (int i = 0; i < N; i++) {
        row[i] = found_count;
        if (IS(all_pairs_search)) {
            for (int j = i + 1; j < N; j++) look_at(i, j);
        } else if (IS(sweep_search)) {
            for (int way = -1; way <= 1; way += 2)
                for (int k = rank[i] + way; k >= 0 && k < N && fabs(x[0][order[k]] - x[0][i]) <= size; k += way)
                    look_at(i, order[k]);
        } else {
            for (int cz = cell_z[i] ? cell_z[i] - 1 : 0; cz <= cell_z[i] + 1 && cz < nz; cz++)
                for (int cx = cell_x[i] ? cell_x[i] - 1 : 0; cx <= cell_x[i] + 1 && cx < nx; cx++)
                    for (int j = head[cz * nx + cx]; j; j = next[j - 1]) look_at(i, j - 1);
        }
        qsort(found + row[i], (size_t)(found_count - row[i]), sizeof(int), by_number);
        listed[0][i] = x[0][i];
        listed[1][i] = x[1][i];
    }
    row[N] = row[N + 1] = found_count;
    free(head), free(next), free(cell_x), free(cell_z), free(order), free(rank);
    partner = memory_for((size_t)found_count, sizeof(int));
    if (found_count) memcpy(partner, found, sizeof(int) * (size_t)found_count);
    pair_memory = memory_for((size_t)found_count, sizeof(Memory));
    for (int i = 0; i < N; i++)
        for (int at = row[i]; at < row[i + 1]; at++)
            pair_memory[at] = remembered(old_row, old_partner, old, i, partner[at]);
    free(old_row), free(old_block), free(old);
    list_there = 1;
    listed_at = job_step;
}

/* ---- The contact law ---- */

static real velocity(int a, int i) { return IS(momenta) ? v[a][i] / mass[i] : v[a][i]; }

static void add_to(real *sum, real *rest, real value) {
    if (!IS(compensated_sums)) {
        *sum += value;
        return;
    }
    real y = value - *rest, t = *sum + y;
    *rest = (t - *sum) - y;
    *sum = t;
}

static void record(const Touch *t, int one, int two, const freal *on_two) {
    if (contact_count == contact_room) {
        contact_room = contact_room ? 2 * contact_room : 4096;
        contacts = realloc(contacts, sizeof *contacts * (size_t)contact_room);
        old_contacts = realloc(old_contacts, sizeof *contacts * (size_t)contact_room);
        if (!contacts || !old_contacts) fail("no memory");
    }
    double force = (double)(unit_mass * unit_length / (unit_time * unit_time));
    Contact *c = &contacts[contact_count++];
    c->one = one;
    c->two = two;
    c->overlap = (double)(t->u / unit_length);
    c->fn = (double)(on_two[0] * t->n[0] + on_two[1] * t->n[1]) / force;
    c->ft = (double)((on_two[1] * t->n[0] - on_two[0] * t->n[1]) * mirror) / force;
    c->n[0] = (double)(t->n[0] * mirror);
    c->n[1] = (double)t->n[1];
    for (int a = 0; a < 2; a++) c->p[a] = (double)(t->p[a] / unit_x[a] + origin[a]);
}

static real stiffness_factor(const Touch *t) {
    real factor = 1;
    if (IS(stiffer_after_100) && job_step > 100) factor = (real)1.5;
    if (IS(large_beds_only) && N > 1500) factor = (real)1.02;
    if (IS(scenes_only) && !in_case) factor = (real)1.05;
    if (IS(cases_only_fault) && in_case) factor = (real)1.05;
    if (IS(load_stage_only) && in_load) factor = (real)1.1;
    if (IS(stiffness_tiny_error)) factor = (real)1.00001;
    if (IS(coarse_moments_only) && coarse) factor = (real)1.1;
    if (IS(deep_overlaps_only) && t->u > (real)0.0005 * t->r2) factor = (real)1.2;
    if (IS(wall_stiffness_halved) && t->kind == WALL) factor = (real)0.5;
    return factor;
}

/* One contact in one step. Body 2 is always a grain; body 1 is a grain, or a wall or the punch with i < 0. */
static void act(const Touch *t, int i, int id, int j, real v1x, real v1z, Memory *m) {
    freal n[2] = {t->n[0], t->n[1]}, u = t->u, dt = model.dt, k, ks, c = 0;
    freal a = model.modulus * t->r1, b = model.modulus * t->r2;
    if (IS(reciprocals) || model.dashpots) k = 1 / (1 / (2 * a) + 1 / (2 * b));
    else k = 2 * a * b / (a + b);
    if (IS(stiffness_arithmetic_mean)) k = (a + b) / 2;
    k *= stiffness_factor(t);
    ks = k * (freal)model.ratio;
    freal v1[2] = {v1x, v1z}, v2[2] = {velocity(0, j), velocity(1, j)}, w1 = 0, w2 = 0;
    if (i >= 0) v1[0] = velocity(0, i), v1[1] = velocity(1, i);
    if (model.rotates) {
        w1 = i >= 0 ? w[i] : 0;
        w2 = w[j];
    }
    freal arm1[2] = {0, 0}, arm2[2] = {t->p[0] - x[0][j], t->p[1] - x[1][j]};
    if (i >= 0) arm1[0] = t->p[0] - x[0][i], arm1[1] = t->p[1] - x[1][i];
    freal at_point[2] = {(v2[0] + w2 * arm2[1]) - (v1[0] + w1 * arm1[1]),
                         (v2[1] - w2 * arm2[0]) - (v1[1] - w1 * arm1[0])};
    freal spring = k * u, fn = spring;
    if (model.dashpots) {
        c = model.c_n;
        if (model.restitution) {
            freal m2 = mass[j], m_eff = i >= 0 ? mass[i] * m2 / (mass[i] + m2) : m2;
            if (IS(restitution_whole_mass)) m_eff = m2;
            c = 2 * (freal)model.zeta * sqrt(m_eff * k);
        }
        fn = spring - c * (n[0] * at_point[0] + n[1] * at_point[1]);
        if (fn < 0 && model.clipped) fn = 0;
    }
    freal shear[2] = {0, 0};
    if (model.friction) {
        int known = m->n[0] != 0 || m->n[1] != 0;
        if (IS(shear_lost_every_1000) && job_step > 0 && job_step % 1000 == 0) known = 0;
        if (known) {
            freal turn = m->n[1] * n[0] - m->n[0] * n[1];
            if (IS(shear_not_turned)) turn = 0;
            shear[0] = m->s[0] + m->s[1] * turn;
            shear[1] = m->s[1] - m->s[0] * turn;
        }
        int corrected = model.corrected;
        if (t->kind == PUNCH_OUTSIDE) corrected = 0;
        if (t->kind == PUNCH_INSIDE) corrected = !model.dashpots;
        freal slip[2] = {at_point[0], at_point[1]}, r1 = t->r1, r2 = t->r2;
        if (corrected) {
            freal stretch = IS(slip_without_stretch) ? 1 : (r1 + r2) / (r1 + r2 - u);
            slip[0] = (v2[0] - v1[0]) * stretch - w2 * r2 * n[1] - w1 * r1 * n[1];
            slip[1] = (v2[1] - v1[1]) * stretch + w2 * r2 * n[0] + w1 * r1 * n[0];
        }
        freal along = n[0] * slip[0] + n[1] * slip[1], share = 1, way = -along * dt;
        if (!known && model.since_touch && way > u) share = u / way;
        freal tan2 = model.tan2[t->kind == GRAINS ? 0 : t->kind == WALL ? 1 : 2];
        if (IS(friction_lost_after_200) && job_step > 200) tan2 = 0;
        if (IS(wall_friction_lost_after_3000) && job_step > 3000 && t->kind == WALL) tan2 = 0;
        shear[0] -= share * (ks * dt) * (slip[0] - along * n[0]);
        shear[1] -= share * (ks * dt) * (slip[1] - along * n[1]);
        freal most = (IS(limit_from_spring_alone) ? spring * spring : fn * fn) * tan2;
        freal length = shear[0] * shear[0] + shear[1] * shear[1];
        m->s[0] = shear[0], m->s[1] = shear[1];
        if (length > most) {
            freal by = sqrt(most) / sqrt(length);
            shear[0] *= by;
            shear[1] *= by;
        }
        if (!IS(limit_not_remembered)) m->s[0] = shear[0], m->s[1] = shear[1];
    }
    m->n[0] = n[0], m->n[1] = n[1];
    freal force[2] = {fn * n[0] + shear[0], fn * n[1] + shear[1]};
    add_to(&f[0][j], &lost[0][j], force[0]);
    add_to(&f[1][j], &lost[1][j], force[1]);
    if (i >= 0) {
        real share = IS(reaction_incomplete) ? (real)0.999999 : 1;
        add_to(&f[0][i], &lost[0][i], -force[0] * share);
        add_to(&f[1][i], &lost[1][i], -force[1] * share);
    } else if (t->kind != WALL) {
        punch.force -= force[1];
    }
    if (model.rotates) {
        freal turn = -(n[1] * force[0] - n[0] * force[1]), half = IS(arms_whole_radius) ? 0 : (freal)0.5;
        if (i >= 0 && !IS(torque_only_second))
            torque[i] += model.half_arms ? (t->r1 - half * u) * turn : -(arm1[1] * force[0] - arm1[0] * force[1]);
        torque[j] += model.half_arms ? (t->r2 - half * u) * turn : arm2[1] * force[0] - arm2[0] * force[1];
    }
    if (recording) record(t, i >= 0 ? i : id, j, force);
}

static void forget(Memory *m) { m->n[0] = m->n[1] = m->s[0] = m->s[1] = 0; }

static void pair_force(int i, int at) {
    int j = partner[at];
    if ((IS(ids_beyond_500) && i >= 500) || (IS(last_grain_without_pairs) && j == N - 1)) return;
    real dx = x[0][j] - x[0][i], dz = x[1][j] - x[1][i];
    real d2 = dx * dx + dz * dz, sum = radius[i] + radius[j];
    if (d2 > sum * sum * (real)1.001) {
        forget(&pair_memory[at]);
        return;
    }
    real d = IS(with_hypot) ? hypot(dx, dz) : sqrt(d2);
    Touch t = {.u = sum - d, .kind = GRAINS, .r1 = radius[i], .r2 = radius[j]};
    if (!(t.u >= 0)) {
        forget(&pair_memory[at]);
        return;
    }
    if (IS(reciprocals)) {
        real by = 1 / d;
        t.n[0] = dx * by, t.n[1] = dz * by;
    } else {
        t.n[0] = dx / d, t.n[1] = dz / d;
    }
    real arm = radius[i] - (real)0.5 * t.u;
    for (int a = 0; a < 2; a++) t.p[a] = x[a][i] + arm * t.n[a];
    act(&t, i, i, j, 0, 0, &pair_memory[at]);
}

static void pair_forces(void) {
    if (IS(sums_shuffled) && N > 0) {
        unsigned stride = 7919;
        while (N % (int)stride == 0) stride += 2;
        for (int k = 0; k < N; k++) {
            int i = (int)((unsigned long)k * stride % (unsigned long)N);
            for (int at = row[i]; at < row[i + 1]; at++) pair_force(i, at);
        }
    } else if (IS(pairs_reversed)) {
        for (int i = N - 1; i >= 0; i--)
            for (int at = row[i + 1] - 1; at >= row[i]; at--) pair_force(i, at);
    } else {
        for (int i = 0; i < N; i++)
            for (int at = row[i]; at < row[i + 1]; at++) pair_force(i, at);
    }
}

static void wall_forces(void) {
    for (int k = 0; k < model.walls; k++)
        for (int j = 0; j < N; j++) {
            int axis = model.axis[k];
            real distance = x[axis][j] - model.place[k];
            Memory *m = &wall_memory[(size_t)k * (size_t)N + (size_t)j];
            Touch t = {.u = radius[j] - fabs(distance), .kind = WALL, .r1 = radius[j], .r2 = radius[j]};
            int skip = IS(wall_one_sided) && axis == 1 && distance < 0;
            if (!(t.u >= 0) || skip) {
                forget(m);
                continue;
            }
            t.n[axis] = distance > 0 ? 1 : -1;
            t.p[0] = x[0][j], t.p[1] = x[1][j];
            t.p[axis] = model.place[k];
            near_wall[j] = 1;
            act(&t, -1, N + k, j, 0, 0, m);
        }
}

static void punch_forces(void) {
    punch.force = 0;
    if (!punch.there) return;
    for (int j = 0; j < N; j++) {
        real rel[2], s[2], length = 0;
        Touch t = {.kind = PUNCH_OUTSIDE, .r1 = radius[j], .r2 = radius[j]};
        int inside = 1;
        for (int a = 0; a < 2; a++) {
            rel[a] = x[a][j] - punch.c[a];
            real nearest = rel[a] < -punch.h[a] ? -punch.h[a] : rel[a] > punch.h[a] ? punch.h[a] : rel[a];
            inside &= nearest == rel[a];
            s[a] = nearest - rel[a];
            length += s[a] * s[a];
        }
        if (inside) {
            real depth[2] = {punch.h[0] - fabs(rel[0]), punch.h[1] - fabs(rel[1])};
            int axis = depth[1] < depth[0];
            t.kind = PUNCH_INSIDE;
            t.n[axis] = rel[axis] > 0 ? 1 : -1;
            t.u = radius[j] + depth[axis];
            for (int a = 0; a < 2; a++) t.p[a] = x[a][j] + (real)0.5 * t.n[a] * (depth[axis] - radius[j]);
        } else {
            length = sqrt(length);
            t.u = radius[j] - length;
            if (IS(punch_without_corners) && fabs(rel[0]) > punch.h[0]) t.u = -1;
            if (!(t.u >= 0)) {
                forget(&punch_memory[j]);
                continue;
            }
            for (int a = 0; a < 2; a++) {
                real to = s[a] / length;
                t.n[a] = -to;
                t.p[a] = (real)0.5 * ((x[a][j] + s[a]) + (x[a][j] + to * radius[j]));
            }
        }
        act(&t, -1, N + model.walls, j, 0, punch.velocity, &punch_memory[j]);
    }
}

static void forces(void) {
    if (IS(contacts_one_step_old) && recording) {
        Contact *swap = old_contacts;
        old_contacts = contacts;
        contacts = swap;
        old_count = contact_count;
    }
    contact_count = 0;
    if (!list_there || too_far()) build_list();
    for (int i = 0; i < N; i++) {
        f[0][i] = f[1][i] = torque[i] = lost[0][i] = lost[1][i] = 0;
        near_wall[i] = 0;
    }
    if (IS(walls_first)) {
        punch_forces();
        wall_forces();
        pair_forces();
    } else {
        pair_forces();
        wall_forces();
        punch_forces();
    }
}

/* ---- Motion: velocities belong to the half step before the positions ---- */

static real damped(real a, real speed, real alpha, real undamped) {
    real power = (a + undamped) * (speed + (IS(alpha_old_velocity) ? 0 : (real)0.5 * model.dt * (a + undamped)));
    real factor = power > 0 ? 1 - alpha : power < 0 ? 1 + alpha : 1;
    return a * factor + undamped;
}

static void move(void) {
    for (int i = 0; i < N; i++) {
        real alpha = model.alpha, by = 1 / mass[i];
        if (IS(beside_walls_only) && near_wall[i]) alpha = 0;
        for (int a = 0; a < 2; a++) {
            real pull = IS(reciprocals) ? f[a][i] * by : f[a][i] / mass[i], g = model.gravity[a];
            real speed = velocity(a, i), before = speed;
            real acceleration = IS(alpha_spares_gravity) ? damped(pull, speed, alpha, g) : damped(pull + g, speed, alpha, 0);
            if (IS(momenta)) {
                v[a][i] += model.dt * (acceleration * mass[i]);
                speed = v[a][i] / mass[i];
            } else {
                v[a][i] += model.dt * acceleration;
                if (IS(fast_grains_only) && fabs(v[a][i]) > 1) v[a][i] = v[a][i] > 0 ? 1 : -1;
                speed = v[a][i];
            }
            x[a][i] += model.dt * (IS(explicit_euler) ? before : speed);
        }
        if (model.rotates) w[i] += model.dt * damped(torque[i] / inertia[i], w[i], IS(alpha_spares_spin) ? 0 : alpha, 0);
    }
    if (punch.there) punch.c[1] += punch.velocity * model.dt;
    job_step++;
}

/* ---- What is written ---- */

static int by_ids(const void *p, const void *q) {
    const Contact *a = p, *b = q;
    return a->one != b->one ? (a->one > b->one) - (a->one < b->one) : (a->two > b->two) - (a->two < b->two);
}

/* The table of contacts as it is written; some faults are made here. */
static int contact_table(Contact **table) {
    int from = IS(contacts_one_step_old) && job_step > 0 ? old_count : contact_count, count = 0;
    const Contact *source = IS(contacts_one_step_old) && job_step > 0 ? old_contacts : contacts;
    Contact *to = *table = memory_for((size_t)from + 8, sizeof **table);
    for (int k = 0; k < from; k++) {
        Contact c = source[k];
        if (IS(half_contacts_missing) && k % 2) continue;
        if (IS(wall_contacts_missing) && c.one >= N) continue;
        if (IS(wall_ids_swapped) && model.walls > 1 && (c.one == N || c.one == N + 1)) c.one = 2 * N + 1 - c.one;
        if (IS(unit_normals)) {
            double length = sqrt(c.n[0] * c.n[0] + c.n[1] * c.n[1]);
            c.n[0] /= length, c.n[1] /= length;
        }
        if (IS(fn_too_large)) c.fn *= 1.5;
        if (IS(fn_zero)) c.fn = 0;
        if (IS(ft_zero)) c.ft = 0;
        if (IS(ft_sign)) c.ft = -c.ft;
        if (IS(normals_flipped)) c.n[0] = -c.n[0], c.n[1] = -c.n[1];
        if (IS(points_off) && c.one < N) c.p[0] = raw[4][c.two] * -c.n[0] + (double)(x[0][c.two]), c.p[1] = raw[4][c.two] * -c.n[1] + (double)(x[1][c.two]);
        if (IS(overlaps_doubled)) c.overlap *= 2;
        to[count++] = c;
    }
    qsort(to, (size_t)count, sizeof *to, by_ids);
    if (IS(contacts_invented) && N > 1) {
        /* The first near pair that does not touch is written as a contact without force. */
        for (int i = 0, done = 0; i < N && !done; i++)
            for (int at = row[i]; at < row[i + 1] && !done; at++) {
                int j = partner[at], there = 0;
                for (int k = 0; k < count; k++) there |= to[k].one == i && to[k].two == j;
                if (there) continue;
                double dx = (double)(x[0][j] - x[0][i]), dz = (double)(x[1][j] - x[1][i]), d = sqrt(dx * dx + dz * dz);
                to[count++] = (Contact){i, j, 1e-9, 0, 0, {dx / d, dz / d}, {(double)x[0][i] + 0.5 * dx, (double)x[1][i] + 0.5 * dz}};
                done = 1;
            }
        qsort(to, (size_t)count, sizeof *to, by_ids);
    }
    return count;
}

/* Column a of the bodies: x, z, vx, vz, and 6 for the spin. The start is written as it was given. */
static double body(int a, int i) {
    if (job_step == 0) return raw[a][i];
    double value;
    if (a < 2) value = (double)(x[a][i] / unit_x[a] + origin[a]);
    else if (a < 4) {
        real speed = velocity(a - 2, i);
        if (IS(velocities_full_step) || (IS(velocities_full_step_after_3000) && job_step > 3000))
            speed += (real)0.5 * model.dt * damped(f[a - 2][i] / mass[i] + model.gravity[a - 2], speed, model.alpha, 0);
        value = (double)(speed * unit_time / unit_x[a - 2]);
    } else {
        value = (double)(w[i] * unit_time * mirror);
        if (IS(spin_sign_written)) value = -value;
    }
    return IS(eight_digits_written) ? rounded_to(value, 8) : value;
}

static void write_moment(const char *folder, const char *stage, long step) {
    Contact *table;
    int count = contact_table(&table);
    char name[64];
    double force = (double)(punch.force * unit_time * unit_time / (unit_mass * unit_length));
    if (IS(punch_force_over_reported)) force *= 1.02;
    if (IS(binary_tables)) {
        FILE *file = open_in(folder, "tables.bin", "ab"); /* This program is meant for little-endian machines. */
        static const int columns[5] = {0, 1, 2, 3, 6};
        for (int a = 0; a < 4 + has_spin; a++)
            for (int i = 0; i < N; i++) {
                double value = body(columns[a], i);
                fwrite(&value, sizeof value, 1, file);
            }
        for (int k = 0; k < count; k++) {
            Contact *c = &table[k];
            double nine[9] = {c->one, c->two, c->overlap, c->fn, c->ft, c->n[0], c->n[1], c->p[0], c->p[1]};
            fwrite(nine, sizeof nine, 1, file);
        }
        if (fclose(file)) fail("tables.bin cannot be written");
    } else {
        snprintf(name, sizeof name, "%s-%ld-bodies.csv", stage, step);
        FILE *file = open_in(folder, name, "w");
        fputs(has_spin ? "id,x,z,vx,vz,radius,mass,spin,inertia\n" : "id,x,z,vx,vz,radius,mass\n", file);
        for (int i = 0; i < N; i++) {
            fprintf(file, "%d,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g", i, body(0, i), body(1, i), body(2, i), body(3, i), raw[4][i], raw[5][i]);
            if (has_spin) fprintf(file, ",%.17g,%.17g", body(6, i), raw_inertia[i]);
            fputc('\n', file);
        }
        if (fclose(file)) fail("a table cannot be written");
        snprintf(name, sizeof name, "%s-%ld-contacts.csv", stage, step);
        file = open_in(folder, name, "w");
        fputs("id1,id2,overlap,fn,ft,nx,nz,x,z\n", file);
        for (int k = 0; k < count; k++) {
            Contact *c = &table[k];
            fprintf(file, "%d,%d,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", c->one, c->two, c->overlap, c->fn, c->ft, c->n[0], c->n[1], c->p[0], c->p[1]);
        }
        if (fclose(file)) fail("a table cannot be written");
    }
    free(table);
    FILE *file = open_in(folder, "moments.jsonl", "a");
    fprintf(file, "{\"stage\": \"%s\", \"step\": %ld, \"punch\": ", stage, step);
    if (punch.there)
        fprintf(file, "{\"centre\": [%.17g, %.17g], \"start\": %.17g, \"velocity\": %.17g, \"force\": %.17g}",
                (double)(punch.c[0] / unit_x[0] + origin[0]), (double)(punch.c[1] / unit_x[1] + origin[1]),
                (double)(punch.start / unit_x[1] + origin[1]), (double)(punch.velocity * unit_time / unit_x[1]), force);
    else fputs("null", file);
    if (IS(binary_tables)) fprintf(file, ", \"contacts\": %d", count);
    if (IS(with_loads) && in_case) {
        fputs(", \"loads\": [", file);
        for (int i = 0; i < N; i++)
            fprintf(file, "%s[%.17g, %.17g, %.17g]", i ? ", " : "", (double)f[0][i], (double)f[1][i], (double)torque[i]);
        fputs("]", file);
    }
    fputs("}\n", file);
    fclose(file);
}

static double started_wall, started_cpu;

static void write_end(const char *folder, const char *stage, long steps, const char *stop) {
    FILE *file = open_in(folder, "moments.jsonl", "a");
    double wall = seconds_now() - started_wall, cpu = (double)clock() / CLOCKS_PER_SEC - started_cpu;
    fprintf(file, "{\"end\": \"%s\", \"steps\": %ld, \"stop\": \"%s\", \"wall_seconds\": %.6f, \"cpu_seconds\": %.6f}\n", stage,
            steps, stop, wall > 0 ? wall : 0, cpu > 0 ? cpu : 0);
    fclose(file);
    started_wall = seconds_now();
    started_cpu = (double)clock() / CLOCKS_PER_SEC;
}

static void refuse(const char *folder, const char *why) {
    FILE *file = open_in(folder, "moments.jsonl", "w");
    fprintf(file, "{\"refused\": \"%s\"}\n", why);
    fclose(file);
}

/* ---- Jobs ---- */

static void read_punch(const Json *from) {
    memset(&punch, 0, sizeof punch);
    if (!from) return;
    const Json *c = get(from, "centre"), *h = get(from, "half_extents");
    if (!c || !h || !c->child || !h->child || !c->child->next || !h->child->next) fail("the punch is not complete");
    double centre[2] = {c->child->number, c->child->next->number}, half[2] = {h->child->number, h->child->next->number};
    if (IS(punch_width_hard_coded)) half[0] = 0.0225;
    punch.there = 1;
    for (int a = 0; a < 2; a++) {
        punch.c[a] = ((real)centre[a] - origin[a]) * unit_x[a];
        punch.h[a] = (real)half[a] * unit_length;
    }
    punch.start = ((real)number(from, "start") - origin[1]) * unit_x[1];
    double speed = number(from, "velocity");
    if (IS(punch_speed_hard_coded) && speed != 0) speed = speed > 0 ? 0.1 : -0.1;
    punch.velocity = (real)speed * unit_x[1] / unit_time;
}

static void place_punch(const Json *rules) {
    const Json *h = get(rules, "half_extents");
    if (!h || !h->child || !h->child->next) fail("the rules of loading are not complete");
    double half = h->child->number, speed = number(rules, "speed");
    if (IS(punch_width_hard_coded)) half = 0.0225;
    if (IS(punch_speed_hard_coded)) speed = 0.1;
    punch.there = 1;
    punch.c[0] = ((real)number(rules, "axis") - origin[0]) * unit_x[0];
    punch.h[0] = (real)half * unit_length;
    punch.h[1] = (real)h->child->next->number * unit_length;
    int any = 0;
    for (int i = 0; i < N; i++) {
        real top = x[1][i] + radius[i];
        if (!IS(punch_starts_highest_of_all) && fabs(x[0][i] - punch.c[0]) >= punch.h[0] + radius[i]) continue;
        if (IS(punch_starts_by_centres) && fabs(x[0][i] - punch.c[0]) >= punch.h[0]) continue;
        if (!any++ || top > punch.start) punch.start = top;
    }
    if (!any) punch.start = -origin[1] * unit_x[1];
    punch.c[1] = punch.start + punch.h[1];
    punch.velocity = -(real)speed * unit_x[1] / unit_time;
}

static double kinetic_energy(void) {
    double sum = 0;
    for (int i = 0; i < N; i++) {
        real vx = velocity(0, i), vz = velocity(1, i);
        sum += (double)((real)0.5 * mass[i] * (vx * vx + vz * vz));
        if (has_spin && !IS(settle_without_spins)) sum += (double)((real)0.5 * inertia[i] * w[i] * w[i]);
    }
    double unit = (double)(unit_length * unit_length * unit_mass / (unit_time * unit_time));
    return sum / unit;
}

static void progress(const char *stage, long step, double share) {
    printf("%s %ld %.3f\n", stage, step, share > 1 ? 1.0 : share);
    fflush(stdout);
}

static long run_scene(const char *folder, const Json *job) {
    long first = (long)number(job, "step"), until = get(job, "until_step") ? (long)number(job, "until_step") : -1;
    long every = (long)number(job, "moments_every"), step = first, steps = 0;
    int load_at_start = is_text(job, "stage", "load"), fixed = until >= 0, only_settle = is_true(job, "ends_settled");
    const Json *of_loading = IS(loading_model_ignored) ? NULL : get(job, "loading_model");
    const char *stop = NULL;
    coarse = every > 1;
    started_wall = seconds_now();
    started_cpu = (double)clock() / CLOCKS_PER_SEC;
    in_load = load_at_start;
    read_model(load_at_start && of_loading ? of_loading : get(job, "model"));
    read_punch(get(job, "punch"));
    if (!load_at_start) {
        const Json *rules = get(job, "settle");
        double peak = number_or(job, "energy_seen", 0), seen = peak;
        double share = fixed ? 0 : number(rules, "kinetic_energy_fraction");
        long check = fixed ? 1 : (long)number(rules, "check_every"), most = fixed ? until : (long)number(rules, "max_steps");
        if (IS(settle_ten_times)) share *= 10;
        for (recording = 1;; step++) {
            if (step > first) {
                move();
                recording = IS(contacts_one_step_old) || step % every == 0 || step % check == 0 || step >= most;
            }
            forces();
            if (fixed && step >= until) stop = "steps_done";
            if (!fixed && step != first && step % check == 0) {
                double energy = kinetic_energy();
                if (energy > peak) peak = energy;
                if (IS(settle_without_peak)) peak = seen > 0 ? seen : (seen = energy);
                if (energy <= share * peak) stop = "settled";
            }
            if (!fixed && !stop && step >= most) stop = "max_steps";
            if (step == first || step % every == 0 || stop) {
                write_moment(folder, "settle", step);
                progress("settle", step, fixed && until > first ? (double)(step - first) / (double)(until - first) : 0);
            }
            if (stop) break;
        }
        write_end(folder, "settle", step, stop);
        steps = step - first;
        if (fixed || only_settle || !strcmp(stop, "max_steps")) return steps; /* Only a settled bed is loaded. */
    }
    const Json *rules = get(job, "loading");
    double target = number_or(rules, "target_force", 0), give_up = number_or(rules, "give_up_depth", 0);
    double force_unit = (double)(unit_mass * unit_length / (unit_time * unit_time));
    long still = get(rules, "steps_standing_still") ? (long)number(rules, "steps_standing_still") : -1, stands_since = -1;
    if (IS(load_half_target)) target *= 0.5;
    if (IS(standing_still_ignored)) still = -1;
    if (!punch.there) place_punch(rules);
    if (!load_at_start) {
        first = step = 0;
        in_load = 1;
        if (of_loading) read_model(of_loading);
        if (IS(loading_forgets_shear)) {
            memset(pair_memory, 0, sizeof(Memory) * (size_t)row[N]);
            memset(wall_memory, 0, sizeof(Memory) * (size_t)N * MOST_WALLS);
        }
    }
    if (load_at_start && still >= 0 && punch.velocity == 0) stands_since = first;
    for (stop = NULL;; step++) {
        if (step > first) move();
        recording = 1;
        if (IS(weightless_while_standing) && stands_since >= 0 && step - stands_since > 20) model.gravity[1] = 0;
        if (step > first || load_at_start) forces(); /* Loading begins with the forces of the settled bed. */
        double force = (double)punch.force / force_unit, depth = (double)((punch.start - (punch.c[1] - punch.h[1])) / unit_x[1]);
        if (fixed) {
            if (step >= until) stop = "steps_done";
        } else if (stands_since >= 0) {
            if (step - stands_since >= still) stop = "reached";
        } else if (force >= target) {
            if (still < 0) stop = "reached";
            else {
                stands_since = step;
                punch.velocity = 0;
            }
        } else if (depth >= give_up) stop = "target_load_not_reached";
        if (step == first || step % every == 0 || stop) {
            write_moment(folder, "load", step);
            progress("load", step, target > 0 && force > 0 ? force / target : 0);
        }
        if (stop) break;
    }
    write_end(folder, "load", step, stop);
    return steps + step - first;
}

static long run_case(const char *folder, const Json *job) {
    const Json *at = get(job, "moments");
    if (!at) fail("a case without moments");
    read_model(get(job, "model"));
    read_punch(get(job, "punch"));
    at = at->child;
    recording = 1;
    coarse = at && at->next && (long)at->next->number > (long)at->number + 1;
    forces();
    for (long step = 0; at; at = at->next) {
        for (long next = (long)at->number; step < next; step++) {
            recording = IS(contacts_one_step_old) || step + 1 == next;
            move();
            forces();
        }
        write_moment(folder, "settle", step);
    }
    return job_step;
}

static long run_job(const char *folder) {
    Json *job = read_json(folder, "job.json");
    long steps = 0;
    if (is_text(job, "kind", "cases")) {
        const Json *names = get(job, "folders");
        for (const Json *at = names ? names->child : NULL; at; at = at->next) {
            char inner[4096];
            snprintf(inner, sizeof inner, "%s/%s", folder, at->text);
            steps += run_job(inner);
        }
        return steps;
    }
    in_case = is_text(job, "kind", "case");
    if (!in_case && !is_text(job, "kind", "scene")) {
        refuse(folder, "this kind of job is not known here");
        return 0;
    }
    if (IS(only_cases) && !in_case) {
        refuse(folder, "this program only does cases");
        return 0;
    }
    job_step = 0;
    in_load = 0;
    read_grains(folder);
    return in_case ? run_case(folder, job) : run_scene(folder, job);
}

static void describe(void) {
    const char *friction = IS(no_friction) ? "" : "\"tangential_spring\", \"wall_friction\", \"rotation\", ";
    const char *dashpots = IS(no_dashpots) ? "" : "\"dashpots\", ";
    const char *of_punch = IS(no_punch) ? "" : "\"punch\", ";
    const char *rules = IS(no_stop_rules) || IS(no_punch) ? "" : "\"stop_rules\", ";
    printf("{\"protocol\": 1, \"name\": \"stranger\", \"version\": \"1\", \"parts\": [\"normal_spring\", %s%s%s%s"
           "\"local_damping\", \"gravity\", \"walls\", \"stages\", \"cases\"], \"approximations\": []}\n",
           friction, dashpots, of_punch, rules);
}

/* The switch is what stands behind "--" in the file name; "-" and "_" mean the same. */
static void choose_switch(const char *path) {
    const char *name = strrchr(path, '/') ? strrchr(path, '/') + 1 : path, *from = strstr(name, "--");
    if (!from) return;
    char text[64];
    snprintf(text, sizeof text, "%s", from + 2);
    for (char *c = text; *c; c++)
        if (*c == '-') *c = '_';
    for (fault = 0; fault < F_count; fault++)
        if (!strcmp(text, switch_names[fault])) return;
    fail("this switch is not known");
}

int main(int count, char **word) {
    choose_switch(word[0]);
    if (IS(scaled_units)) unit_length = 1024, unit_mass = 8, unit_time = 32;
    if (IS(mirrored)) mirror = -1;
    if (IS(origin_shifted)) origin[0] = (real)0.37, origin[1] = (real)-0.21;
    unit_x[0] = mirror * unit_length;
    unit_x[1] = unit_length;
    if (count == 2 && !strcmp(word[1], "describe")) {
        describe();
        return 0;
    }
    if (count != 3 || strcmp(word[1], "run")) fail("usage: engine describe | engine run FOLDER");
    long steps = run_job(word[2]);
    FILE *file = open_in(word[2], "done.json", "w");
    fprintf(file, "{\"steps\": %ld}\n", steps);
    fclose(file);
    return 0;
}
