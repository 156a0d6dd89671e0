/* A discrete-element engine of its own, with switches: the corpus of right and wrong engines on which verdicts are tested.
 *
 * It was written from docs/engine-protocol.md and docs/determinism.md and shares no code with the native engine.
 *
 *     cc -std=c11 -O2 engine.c -lm -o engine
 *     engine describe | engine run FOLDER
 *
 * Which right engine it is, is chosen when it is compiled; each of these is right but for rounding:
 *
 *     -DREAL=float|"long double"   type of the state
 *     -DFORCE=float|"long double"  type of contacts, forces and their sums, computed from differences of places
 *     -DREVERSED                   forces on a grain summed from the highest partner down
 *     -DPAIRWISE                   forces on a grain collected and summed pairwise
 *     -DKAHAN                      forces summed with a compensation
 *     -DRECIPROCAL                 x*(1/d) instead of x/d
 *     -DVERLET                     velocity Verlet, with the velocities at whole steps inside
 *     -DCOMPLIANCES                springs in series by their compliances
 *     -DHYPOT                      distances by hypot
 *     -DUNITS                      units of its own inside
 *
 * and so is what compiler flags do (-ffast-math, -mfma -ffp-contract=fast, -mfpmath=387 …).
 * Which wrong engine it is, is chosen when it runs, by the variable FAULT, such as FAULT="k_n=1.05,history_reset"; a fault
 * without a number is 1. The names are FACTORS and FAULTS below; one that is unknown ends the program.
 *
 * corpus.json lists the variants. `cause` is what a diagnosis should name: a constant, with its `factor` (of gravity_x the share
 * of gravity, of wall_place that of the mean radius; null where it depends on the scene), or a key of its own. `needs` is
 * what a scene must have to show it. differences.py checks that right ones are right and that each fault is one.
 *
 * Which conventions it has, is chosen when it runs too, by the variable RULES, such as RULES="slip=unstretched,tension=cut"; the
 * names are those of docs/rules.md, from which they were written. It declares them, or those in the variable DECLARED if there
 * is one. -DVERLET knows no rules.
 *
 * An engine that is one file and needs no environment, for exec:PATH, is a script of two lines:
 *
 *     #!/bin/sh
 *     FAULT="k_n=1.05" exec /where/it/is/engine "$@"
 */
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include <time.h>

#ifndef REAL
#define REAL double
#endif
#ifndef FORCE
#define FORCE REAL
#endif
typedef REAL real;
typedef FORCE local;

#ifdef RECIPROCAL
#define OVER(a, b) ((a) * (1 / (b)))
#else
#define OVER(a, b) ((a) / (b))
#endif

/* What SI units are counted in inside. */
#ifdef UNITS
static const double LENGTH = 0.0047, TIME = 3.1e-5, MASS = 0.19;
#else
static const double LENGTH = 1, TIME = 1, MASS = 1;
#endif

/* Numbers that are 1 in a right engine. Constants are multiplied by them; mass_one and radius_one are those of grain N/2.
 * first_kick: how much of dt the first kick has. drift: how much of the kick the velocity has that moves the grains.
 * damping_velocity: the damping is judged by v + so many halves of dt·a. */
#define FACTORS                                                                                                        \
    X(k_n) X(k_n_grain) X(k_n_wall) X(k_n_punch) X(k_s) X(tan_phi) X(alpha) X(gravity) X(dt) X(mass) X(mass_one)       \
    X(inertia) X(c_n) X(radius) X(radius_one) X(punch_speed) X(first_kick) X(drift) X(damping_velocity)

/* Numbers that are 0 in a right engine. */
#define FAULTS                                                                                                         \
    X(gravity_x)            /* gravity across, over gravity */                                                         \
    X(wall_place)           /* the last wall is so many mean radii too high */                                         \
    X(written_velocity)     /* velocities are written of the whole step */                                             \
    X(damping_off_gravity)  /* gravity is not damped */                                                                \
    X(damping_vector)       /* both components are judged by a·v */                                                    \
    X(damping_off_spin)     /* spins are not damped */                                                                 \
    X(stiffness_mean)       /* 1 arithmetic, 2 geometric, 3 the smaller, 4 the first, instead of the harmonic one */    \
    X(law_nonlinear)        /* k u (1 + it u/R) */                                                                     \
    X(wall_missing)         /* the first wall, the second, … */                                                        \
    X(punch_missing)                                                                                                   \
    X(punch_corners)        /* 1: corners do not touch; 2: they push like the bottom */                                \
    X(punch_late)           /* the punch moves after the forces */                                                     \
    X(contacts_lost_near)   /* pairs nearer than so many mean radii */                                                 \
    X(contacts_lost_far)    /* pairs farther than so many mean radii */                                                \
    X(contacts_lost_across) /* pairs across the middle of all grains */                                                \
    X(contacts_twice)       /* these pairs count twice */                                                              \
    X(contacts_late)        /* only pairs that touched a step before */                                                \
    X(contacts_every)       /* only pairs that touched at the last search, every so many steps */                      \
    X(normal_old)           /* normals of the places before the step */                                                \
    X(places_old)           /* grains touch where they were before the step */                                         \
    X(third_law)            /* a pair pushes only 1: its second, 2: its first grain */                                 \
    X(history_reset) X(history_not_turned) X(history_turned_back)                                                      \
    X(history_length)    /* 1: the shear force keeps its length as it turns; 2: it is projected */                     \
    X(slip_not_stretched)                                                                                              \
    X(coulomb_missing)                                                                                                 \
    X(coulomb_components) /* each component of the shear force is cut by itself */                                     \
    X(coulomb_spring)     /* the limit is that of the spring without the dashpot */                                    \
    X(tan_phi_is_phi)                                                                                                  \
    X(slip_other)        /* the other slip velocity */                                                                 \
    X(slip_without_spin)                                                                                               \
    X(new_contact_other) /* the other share of a new contact's first step */                                           \
    X(torque_arms)       /* 1: R instead of R - u/2; 2: at walls and punch alone */                                    \
    X(torque_sign)       /* on the second grain */                                                                     \
    X(torque_off_flat)   /* walls and punch do not turn grains */                                                      \
    X(spin_missing)      /* spins stay as they are */                                                                  \
    X(clipping)          /* the other way */                                                                           \
    X(dashpot_whole)     /* a dashpot on the tangential velocity too */                                                \
    X(dashpot_mass)      /* the mean of two masses instead of the effective mass */

/* Every alternative of a rule but the first ones. */
#define RULES                                                                                                          \
    X(given_velocities, at_start) X(written_velocities, whole_step) X(integration, drift_kick) X(integration, taylor)  \
    X(damping_velocity, before) X(damping_velocity, after) X(damped_gravity, spared)                                   \
    X(damping_components, whole_power) X(damping_components, along_velocity) X(damped_spins, undamped)                 \
    X(stiffness_mean, arithmetic) X(stiffness_mean, geometric) X(stiffness_mean, smaller) X(stiffness_mean, larger)    \
    X(wall_stiffness, rigid) X(wall_mass, half)                                                                        \
    X(slip, corrected) X(slip, contact_point) X(slip, unstretched)                                                     \
    X(slip_at_walls, contact_point) X(slip_at_walls, half_overlap) X(slip_at_walls, unstretched)                       \
    X(torque_arms, half_overlap) X(torque_arms, contact_point) X(torque_arms, whole_radii)                             \
    X(torque_arms_at_walls, half_overlap) X(torque_arms_at_walls, contact_point) X(torque_arms_at_walls, whole_radii)  \
    X(spring_turn, keeps_length) X(spring_turn, projected) X(spring_turn, not_turned) X(slip_added, before_turn)       \
    X(spring_when_sliding, unlimited) X(spring_when_sliding, nothing)                                                  \
    X(tangential_dashpot, within_limit) X(tangential_dashpot, beyond_limit) X(tangential_dashpot, while_sticking)      \
    X(limit_from, spring) X(tension, cut) X(tension, not_cut) X(restitution, uncut) X(restitution, cut)                \
    X(new_contact, whole_step) X(new_contact, since_touch) X(new_contact, nothing)

typedef struct {
#define X(rule, choice) bool rule##_##choice;
    RULES
#undef X
} Rules;
static Rules rule, declared;

static struct {
#define X(name) double name;
    FACTORS FAULTS
#undef X
} fault = {
#define X(name) .name = 1,
    FACTORS
#undef X
};

_Noreturn static void fail(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
    exit(1);
}

static void *resized(void *old, size_t count, size_t size)
{
    void *new = realloc(old, (count + 1) * size);
    if (!new) fail("out of memory");
    return new;
}

static void read_faults(void)
{
    static const struct { const char *name; double *value; } known[] = {
#define X(name) {#name, &fault.name},
        FACTORS FAULTS
#undef X
    };
    const char *at = getenv("FAULT");
    while (at && *at) {
        size_t length = strcspn(at, "=,"), index = 0, most = sizeof known / sizeof *known;
        while (index < most && (strlen(known[index].name) != length || strncmp(known[index].name, at, length))) index++;
        if (index == most) fail("no such fault: %s", at);
        *known[index].value = at[length] == '=' ? atof(at + length + 1) : 1;
        at += strcspn(at, ",");
        at += *at == ',';
    }
}

/* Those of the variable, or these others if there is none. */
static Rules read_rules(const char *variable, Rules others)
{
    Rules read = {0};
    const struct { const char *name; bool *value; } known[] = {
#define X(rule, choice) {#rule "=" #choice, &read.rule##_##choice},
        RULES
#undef X
    };
    const char *at = getenv(variable);
    if (!at) return others;
    while (*at) {
        size_t length = strcspn(at, ","), index = 0, most = sizeof known / sizeof *known;
        while (index < most && (strlen(known[index].name) != length || strncmp(known[index].name, at, length))) index++;
        if (index == most) fail("no such rule: %s", at);
        *known[index].value = true;
        at += length;
        at += *at == ',';
    }
    return read;
}

static void describe(void)
{
    const char *before = ", \"rules\": {";
    bool any = false;
#define X(rule, choice) any |= declared.rule##_##choice;
    RULES
#undef X
    printf("{\"protocol\": %d, \"name\": \"corpus\", \"version\": \"1\", \"parts\": [\"normal_spring\", \"tangential_spring\", "
           "\"rotation\", \"dashpots\", \"local_damping\", \"gravity\", \"walls\", \"punch\", \"cases\"]", any ? 2 : 1);
#define X(rule, choice) if (declared.rule##_##choice) printf("%s\"" #rule "\": \"" #choice "\"", before), before = ", ";
    RULES
#undef X
    puts(any ? "}}" : "}");
}

/* ---- JSON, trusted: a value is a place in the text ---- */

static const char *space(const char *at) { return at + strspn(at, " \t\r\n:,"); }

/* Behind the value here; in an object the names and the values follow each other. */
static const char *behind(const char *at)
{
    if (*at == '"') {
        for (at++; *at && *at != '"'; at++) at += *at == '\\';
        return at + 1;
    }
    if (*at == '{' || *at == '[') {
        for (at = space(at + 1); *at && *at != '}' && *at != ']';) at = space(behind(at));
        return at + 1;
    }
    return at + strcspn(at, ",]} \t\r\n");
}

static const char *member(const char *object, const char *name)
{
    size_t length = strlen(name);
    for (const char *at = space(object + 1); *at == '"'; at = space(behind(space(behind(at)))))
        if (!strncmp(at + 1, name, length) && at[length + 1] == '"') return space(behind(at));
    fail("the job has no %s", name);
}

/* NULL behind the last one. */
static const char *item(const char *list, int index)
{
    const char *at = space(list + 1);
    while (index-- && *at != ']') at = space(behind(at));
    return *at == ']' ? NULL : at;
}

static double number(const char *object, const char *name) { return atof(member(object, name)); }

static bool is(const char *object, const char *name, const char *text)
{
    const char *at = member(object, name);
    return !strncmp(at + 1, text, strlen(text)) && at[strlen(text) + 1] == '"';
}

/* ---- state and constants ---- */

/* Components: x, z and the angle, with mass, mass and moment of inertia. */
typedef struct {
    real x[3], v[3], acceleration[3], old[2], mass[3], radius;
    local force[3], lost[3];
    double given[5];
} Grain;

/* Force and torques are on the second body, always a grain; the first one bears the opposite force. */
typedef struct {
    int first, second;
    bool at_wall, inside_punch;
    local normal[2], overlap, shear[2], force[2], torques[2];
} Contact;

typedef struct { Contact *of; size_t count, room; } List; /* by rising ids */
typedef struct { int first, second; } Pair;
typedef struct { int axis; real place; } Wall;

static Grain *grains;
static int count, components;
static Wall *walls;
static int wall_count;
static struct { bool there; real x[2], half[2], velocity; double start, force; } punch;
static List contacts, before; /* of this step and of the step before */
static Pair *pairs;           /* of grains that may touch, by rising ids */
static size_t pair_count, pair_room;
static int searches;
static bool first_step;

static real gravity[3], alpha, dt, mean_radius, middle;
static local modulus, stiffness_ratio, tan_phi, damping_ratio, damping_constant;
static bool friction, turns, dashpots, clipped, corrected, slips_at_point, half_overlap, whole_step;

/* ---- where bodies touch ---- */

static const real *place(const Grain *of) { return fault.places_old ? of->old : of->x; }

static bool touches_grain(Contact *of)
{
    const Grain *one = &grains[of->first], *two = &grains[of->second];
    const real *a = place(one), *b = place(two);
    const local dx = b[0] - a[0], dz = b[1] - a[1];
#ifdef HYPOT
    const local distance = hypot(dx, dz);
#else
    const local distance = sqrt(dx * dx + dz * dz);
#endif
    of->overlap = (local)(one->radius + two->radius) - distance;
    of->normal[0] = OVER(dx, distance);
    of->normal[1] = OVER(dz, distance);
    if (fault.normal_old) {
        const real old_x = two->old[0] - one->old[0], old_z = two->old[1] - one->old[1];
        of->normal[0] = old_x / hypot(old_x, old_z);
        of->normal[1] = old_z / hypot(old_x, old_z);
    }
    const bool lost = (fault.contacts_lost_near && distance < fault.contacts_lost_near * mean_radius)
        || (fault.contacts_lost_far && distance > fault.contacts_lost_far * mean_radius)
        || (fault.contacts_lost_across && (a[0] < middle) != (b[0] < middle));
    return of->overlap >= 0 && !lost;
}

static bool touches_wall(Contact *of)
{
    const int index = of->first - count, axis = walls[index].axis;
    const local distance = place(&grains[of->second])[axis] - walls[index].place;
    of->at_wall = true;
    of->overlap = (local)grains[of->second].radius - fabs(distance);
    of->normal[axis] = distance > 0 ? 1 : -1;
    return of->overlap >= 0 && fault.wall_missing != index + 1;
}

static bool touches_punch(Contact *of)
{
    const real *x = place(&grains[of->second]);
    const local half[2] = {punch.half[0], punch.half[1]}, radius = grains[of->second].radius;
    const local relative[2] = {x[0] - punch.x[0], x[1] - punch.x[1]};
    local out[2]; /* from the nearest point of the rectangle */
    for (int axis = 0; axis < 2; axis++)
        out[axis] = fabs(relative[axis]) <= half[axis] ? 0 : relative[axis] - copysign(half[axis], relative[axis]);
    if (out[0] != 0 && out[1] != 0 && fault.punch_corners) {
        if (fault.punch_corners == 1) return false;
        out[0] = 0;
    }
    if (out[0] == 0 && out[1] == 0) {
        const local depth[2] = {half[0] - fabs(relative[0]), half[1] - fabs(relative[1])};
        const int axis = depth[1] < depth[0];
        of->inside_punch = true;
        of->overlap = radius + depth[axis];
        of->normal[axis] = relative[axis] > 0 ? 1 : -1;
        return true;
    }
    const local distance = sqrt(out[0] * out[0] + out[1] * out[1]);
    of->overlap = radius - distance;
    of->normal[0] = OVER(out[0], distance);
    of->normal[1] = OVER(out[1], distance);
    return of->overlap >= 0;
}

/* ---- the law of a contact ---- */

static local in_series(local a, local b)
{
    if (rule.stiffness_mean_larger) return a > b ? a : b;
    const bool of_rules[] = {rule.stiffness_mean_arithmetic, rule.stiffness_mean_geometric, rule.stiffness_mean_smaller};
    int mean = (int)fault.stiffness_mean;
    for (int at = 0; at < 3; at++) if (of_rules[at]) mean = at + 1;
    switch (mean) {
    case 1: return (a + b) / 2;
    case 2: return sqrt(a * b);
    case 3: return a < b ? a : b;
    case 4: return a;
    }
#ifdef COMPLIANCES
    return 1 / (1 / (2 * a) + 1 / (2 * b));
#else
    return OVER(2 * a * b, a + b);
#endif
}

static local dashpot_constant(const Contact *of, local k_n)
{
    if (damping_constant > 0) return damping_constant;
    local mass = grains[of->second].mass[0] / (of->first >= count && rule.wall_mass_half ? 2 : 1);
    if (of->first < count) {
        const local other = grains[of->first].mass[0];
        mass = fault.dashpot_mass ? (mass + other) / 2 : OVER(mass * other, mass + other);
    }
    return 2 * damping_ratio * sqrt(mass * k_n) * fault.c_n;
}

static void cut(local shear[2], local limit)
{
    if (fault.coulomb_missing) return;
    if (fault.coulomb_components) {
        for (int axis = 0; axis < 2; axis++)
            if (fabs(shear[axis]) > limit) shear[axis] = copysign(limit, shear[axis]);
        return;
    }
    const local squared = shear[0] * shear[0] + shear[1] * shear[1];
    if (squared > limit * limit)
        for (int axis = 0; axis < 2; axis++) shear[axis] *= OVER(limit, sqrt(squared));
}

/* What was remembered under the old normal, under the new one. */
static void turn_round(const local was[2], const local old[2], const local now[2], local shear[2])
{
    const local nx = now[0], nz = now[1];
    local turn = old[1] * nx - old[0] * nz;
    if (fault.history_not_turned || rule.spring_turn_not_turned) turn = 0;
    if (fault.history_turned_back) turn = -turn;
    const local on_both[2] = {was[0] + was[1] * turn, was[1] - was[0] * turn};
    const bool keeps = fault.history_length == 1 || rule.spring_turn_keeps_length;
    const local off = was[0] * nx + was[1] * nz, on[2] = {was[0] - off * nx, was[1] - off * nz};
    const local length = sqrt(on[0] * on[0] + on[1] * on[1]);
    const local factor = keeps && length > 0 ? OVER(sqrt(was[0] * was[0] + was[1] * was[1]), length) : 1;
    const bool projects = keeps || fault.history_length || rule.spring_turn_projected;
    for (int axis = 0; axis < 2; axis++) shear[axis] = projects ? factor * on[axis] : on_both[axis];
}

/* What the contact does in this step; `old` is the same contact a step before, if it was there. */
static void act(Contact *of, const Contact *old)
{
    const bool flat = of->first >= count, of_punch = flat && !of->at_wall;
    const Grain *two = &grains[of->second], *one = flat ? two : &grains[of->first];
    const local r1 = one->radius, r2 = two->radius, u = of->overlap;
    const local nx = of->normal[0], nz = of->normal[1];
    const local kind = flat ? of_punch ? fault.k_n_punch : fault.k_n_wall : fault.k_n_grain;
    const local rigid = flat && rule.wall_stiffness_rigid ? 2 : 1;
    const local k_n = in_series(modulus * r1, modulus * r2) * (local)fault.k_n * kind * rigid;
    const local k_s = in_series(modulus * stiffness_ratio * r1, modulus * stiffness_ratio * r2) * (local)fault.k_s * rigid;

    local velocity[2];
    for (int axis = 0; axis < 2; axis++)
        velocity[axis] = two->v[axis] - (!flat ? one->v[axis] : of_punch && axis == 1 ? punch.velocity : 0);
    const local apart = nx * velocity[0] + nz * velocity[1];
    local spring = k_n * u, c_n = 0;
    if (fault.law_nonlinear) spring *= 1 + fault.law_nonlinear * u / r2;
    local pressure = spring;
    if (dashpots) {
        c_n = dashpot_constant(of, k_n);
        pressure -= c_n * apart;
        if (pressure < 0 && clipped) pressure = 0;
    }

    /* A point of the surface is so far from the centre. */
    const local arm1 = r1 - u / 2, arm2 = of->at_wall ? r2 - u : r2 - u / 2;
    local force[2] = {0, 0}; /* along the tangent */
    if (friction) {
        const bool turns_now = old && !fault.history_reset;
        if (turns_now && rule.slip_added_before_turn) memcpy(of->shear, old->shear, sizeof of->shear);
        else if (turns_now) turn_round(old->shear, old->normal, of->normal, of->shear);
        /* At the punch only what is inside it is corrected, whatever is chosen. */
        bool correct = of_punch ? of->inside_punch && !dashpots : corrected, at_point = of_punch ? !correct : slips_at_point;
        if (flat && rule.slip_at_walls_contact_point) correct = false, at_point = true;
        if (flat && (rule.slip_at_walls_unstretched || rule.slip_at_walls_half_overlap)) correct = at_point = false;
        const local stretch = correct && !fault.slip_not_stretched ? OVER(r1 + r2, r1 + r2 - u) : 1;
        const local flat_arm = rule.slip_at_walls_half_overlap ? r2 - u / 2 : at_point ? arm2 : r2;
        local rolling = flat ? two->v[2] * flat_arm : one->v[2] * (at_point ? arm1 : r1) + two->v[2] * (at_point ? arm2 : r2);
        if (fault.slip_without_spin) rolling = 0;
        const local relative[2] = {velocity[0] * stretch - rolling * nz, velocity[1] * stretch + rolling * nx};
        const local along = nx * relative[0] + nz * relative[1], way = -along * (local)dt;
        const local slip[2] = {relative[0] - along * nx, relative[1] - along * nz};
        local share = old || whole_step || way <= u ? 1 : OVER(u, way);
        if (!old && rule.new_contact_nothing) share = 0;
        for (int axis = 0; axis < 2; axis++) of->shear[axis] -= share * k_s * (slip[axis] * (local)dt);
        if (turns_now && rule.slip_added_before_turn) {
            const local unturned[2] = {of->shear[0], of->shear[1]};
            turn_round(unturned, old->normal, of->normal, of->shear);
        }
        const local limit = fabs(fault.coulomb_spring || rule.limit_from_spring ? spring : pressure) * tan_phi;
        const bool within = rule.tangential_dashpot_within_limit;
        const bool brakes = within || rule.tangential_dashpot_beyond_limit || rule.tangential_dashpot_while_sticking;
        const local brake[2] = {brakes ? -c_n * slip[0] : 0, brakes ? -c_n * slip[1] : 0};
        local uncut[2];
        for (int axis = 0; axis < 2; axis++) force[axis] = uncut[axis] = of->shear[axis] + (within ? brake[axis] : 0);
        cut(force, limit);
        const bool slides = force[0] != uncut[0] || force[1] != uncut[1];
        for (int axis = 0; axis < 2; axis++) {
            if (slides && rule.spring_when_sliding_nothing) of->shear[axis] = 0;
            else if (slides && !rule.spring_when_sliding_unlimited) of->shear[axis] = force[axis] - (within ? brake[axis] : 0);
            const bool sticks = rule.tangential_dashpot_while_sticking && !slides;
            if (rule.tangential_dashpot_beyond_limit || sticks) force[axis] += brake[axis];
        }
    }
    of->force[0] = pressure * nx + force[0];
    of->force[1] = pressure * nz + force[1];
    if (fault.dashpot_whole && pressure != 0) {
        of->force[0] -= c_n * (velocity[0] - apart * nx);
        of->force[1] -= c_n * (velocity[1] - apart * nz);
    }
    if (turns && !(flat && fault.torque_off_flat)) {
        const local sideways = nx * of->force[1] - nz * of->force[0];
        bool whole = fault.torque_arms == 1 || (fault.torque_arms == 2 && flat) || rule.torque_arms_whole_radii;
        bool half = half_overlap;
        if (flat && (rule.torque_arms_at_walls_half_overlap || rule.torque_arms_at_walls_contact_point))
            whole = false, half = rule.torque_arms_at_walls_half_overlap;
        if (flat && rule.torque_arms_at_walls_whole_radii) whole = true;
        of->torques[0] = (whole ? r1 : arm1) * sideways;
        of->torques[1] = (whole ? r2 : half ? r2 - u / 2 : arm2) * sideways;
        if (fault.torque_sign) of->torques[1] *= -1;
    }
}

/* ---- sums ---- */

#ifdef PAIRWISE
enum { MOST = 64 };
static struct { int count; local of[3][MOST]; } *collected;

static local total(const local *of, int n)
{
    return n == 0 ? 0 : n == 1 ? *of : total(of, n / 2) + total(of + n / 2, n - n / 2);
}
#endif

static void add(int id, const local load[3])
{
#ifdef PAIRWISE
    if (collected[id].count == MOST) fail("a grain with more than %d contacts", MOST);
    const int at = collected[id].count++;
    for (int c = 0; c < 3; c++) collected[id].of[c][at] = load[c];
#else
    Grain *of = &grains[id];
    for (int c = 0; c < 3; c++) {
#ifdef KAHAN
        const local with = load[c] - of->lost[c], sum = of->force[c] + with;
        of->lost[c] = (sum - of->force[c]) - with;
        of->force[c] = sum;
#else
        of->force[c] += load[c];
#endif
    }
#endif
}

static void sum_forces(void)
{
    for (int id = 0; id < count; id++)
        for (int c = 0; c < 3; c++) grains[id].force[c] = grains[id].lost[c] = 0;
#ifdef PAIRWISE
    collected = resized(collected, count, sizeof *collected);
    for (int id = 0; id < count; id++) collected[id].count = 0;
#endif
    punch.force = 0;
    for (size_t at = 0; at < contacts.count; at++) {
#ifdef REVERSED
        const Contact *of = &contacts.of[contacts.count - 1 - at];
#else
        const Contact *of = &contacts.of[at];
#endif
        const bool of_grains = of->first < count;
        const local times = fault.contacts_twice && of_grains
            && (grains[of->first].x[0] < middle) != (grains[of->second].x[0] < middle) ? 2 : 1;
        const local on_first[3] = {-times * of->force[0], -times * of->force[1], times * of->torques[0]};
        const local on_second[3] = {times * of->force[0], times * of->force[1], times * of->torques[1]};
        if (of_grains && fault.third_law != 1) add(of->first, on_first);
        if (!of_grains || fault.third_law != 2) add(of->second, on_second);
        if (of->first == count + wall_count) punch.force -= of->force[1];
    }
#ifdef PAIRWISE
    for (int id = 0; id < count; id++)
        for (int c = 0; c < 3; c++) grains[id].force[c] = total(collected[id].of[c], collected[id].count);
#endif
}

/* ---- the search ---- */

static int by_number(const void *a, const void *b) { return *(const int *)a - *(const int *)b; }

static const real *searched(int id) { return fault.contacts_late ? grains[id].old : grains[id].x; }

/* Lists the pairs of grains that are near enough to touch, with a grid of cells as wide as the largest grain. */
static void search(void)
{
    enum { CELLS = 512, BELOW_ZERO = 128 }; /* on each axis; what is beyond goes into the outermost ones */
    static int first[CELLS][CELLS], *next;
    const bool only_touching = fault.contacts_late || fault.contacts_every;
    const real margin = only_touching ? 1 : 1.001; /* rounding must not lose a pair */
    real width = 0;
    for (int id = 0; id < count; id++) width = fmax(width, 2 * margin * grains[id].radius);
#define CELL(id, axis) (int)fmin(fmax(searched(id)[axis] / width + BELOW_ZERO, 0), CELLS - 1)
    next = resized(next, count, sizeof *next);
    memset(first, -1, sizeof first);
    for (int id = 0; id < count; id++) {
        int *cell = &first[CELL(id, 1)][CELL(id, 0)];
        next[id] = *cell;
        *cell = id;
    }
    pair_count = 0;
    for (int id = 0; id < count; id++) {
        const size_t begin = pair_count;
        const int row = CELL(id, 1), column = CELL(id, 0);
        for (int r = row ? row - 1 : 0; r <= row + 1 && r < CELLS; r++)
            for (int c = column ? column - 1 : 0; c <= column + 1 && c < CELLS; c++)
                for (int other = first[r][c]; other >= 0; other = next[other]) {
                    const real dx = searched(other)[0] - searched(id)[0], dz = searched(other)[1] - searched(id)[1];
                    const real reach = margin * (grains[id].radius + grains[other].radius);
                    if (other <= id || dx * dx + dz * dz > reach * reach) continue;
                    if (pair_count == pair_room) pairs = resized(pairs, pair_room = 2 * pair_room + 64, sizeof *pairs);
                    pairs[pair_count++] = (Pair){other, id}; /* sorted by the other one, then turned round */
                }
        qsort(pairs + begin, pair_count - begin, sizeof *pairs, by_number);
        for (size_t at = begin; at < pair_count; at++) pairs[at] = (Pair){id, pairs[at].first};
    }
#undef CELL
}

/* ---- a step ---- */

static int in_order(const Contact *a, const Contact *b)
{
    return a->first != b->first ? a->first - b->first : a->second - b->second;
}

/* Adds the pair to the contacts if it touches; `old` goes along the contacts of the step before, which rise by ids too. */
static void consider(int first, int second, bool touches(Contact *), size_t *old)
{
    Contact of = {.first = first, .second = second};
    if (!touches(&of)) return;
    while (*old < before.count && in_order(&before.of[*old], &of) < 0) ++*old;
    act(&of, *old < before.count && in_order(&before.of[*old], &of) == 0 ? &before.of[*old] : NULL);
    if (contacts.count == contacts.room)
        contacts.of = resized(contacts.of, contacts.room = 2 * contacts.room + 64, sizeof *contacts.of);
    contacts.of[contacts.count++] = of;
}

static void evaluate_forces(void)
{
    const List freed = before;
    before = contacts;
    contacts = (List){freed.of, 0, freed.room};
    if (!fault.contacts_every || searches++ % (int)fault.contacts_every == 0) search();
    size_t old = 0;
    for (size_t at = 0; at < pair_count; at++) consider(pairs[at].first, pairs[at].second, touches_grain, &old);
    for (int index = 0; index < wall_count; index++)
        for (int id = 0; id < count; id++) consider(count + index, id, touches_wall, &old);
    if (punch.there && !fault.punch_missing)
        for (int id = 0; id < count; id++) consider(count + wall_count, id, touches_punch, &old);
    sum_forces();
}

/* Accelerations, damped. The velocities are those half a step before the forces. */
static void accelerate(Grain *of)
{
    real power[3], judged[3], *a = of->acceleration;
    const bool spared = fault.damping_off_gravity || rule.damped_gravity_spared;
    const real halves = rule.damping_velocity_before ? 0 : rule.damping_velocity_after ? 2 : fault.damping_velocity;
    for (int c = 0; c < components; c++) {
        a[c] = OVER(of->force[c], of->mass[c]) + gravity[c];
        judged[c] = of->v[c] + halves * (dt / 2 * a[c]);
        if (spared) a[c] -= gravity[c];
        power[c] = a[c] * judged[c];
    }
    if (fault.damping_vector || rule.damping_components_whole_power) power[0] = power[1] = power[0] + power[1];
    const real size = alpha * sqrt(a[0] * a[0] + a[1] * a[1]), speed = sqrt(judged[0] * judged[0] + judged[1] * judged[1]);
    for (int c = 0; c < components; c++) {
        const bool undamped = c == 2 && (fault.damping_off_spin || rule.damped_spins_undamped);
        if (c < 2 && rule.damping_components_along_velocity) a[c] -= speed > 0 ? OVER(size * judged[c], speed) : 0;
        else if (!undamped) a[c] *= 1 - alpha * ((power[c] > 0) - (power[c] < 0));
        if (spared) a[c] += gravity[c];
    }
}

/* With VERLET velocities are those of whole steps, but for the time between their two halves. */
static void finish_kick(void)
{
#ifdef VERLET
    for (int id = 0; id < count; id++) {
        accelerate(&grains[id]);
        for (int c = 0; c < components; c++) grains[id].v[c] += dt / 2 * grains[id].acceleration[c];
    }
#endif
}

static void move_punch(void) { punch.x[1] += punch.velocity * dt; }

static void step_once(void)
{
    if (!fault.punch_late) move_punch();
    const real kick = first_step ? dt * (real)(rule.given_velocities_at_start ? 0.5 : fault.first_kick) : dt;
    for (int id = 0; id < count; id++) {
        Grain *of = &grains[id];
        memcpy(of->old, of->x, sizeof of->old);
#ifdef VERLET
        for (int c = 0; c < components; c++) {
            of->v[c] += kick / 2 * of->acceleration[c];
            of->x[c] += dt * of->v[c];
        }
#else
        accelerate(of);
        for (int c = 0; c < components; c++) {
            const real change = kick * of->acceleration[c];
            const real drift = rule.integration_drift_kick ? 0 : (real)fault.drift;
            of->x[c] += dt * (of->v[c] + (rule.integration_taylor ? dt / 2 * of->acceleration[c] : drift * change));
            of->v[c] += change;
        }
#endif
    }
    first_step = false;
    evaluate_forces();
    finish_kick();
    if (fault.punch_late) move_punch();
}

/* The velocity half a step before the places. */
static real half_step_velocity(Grain *of, int c)
{
#ifdef VERLET
    return of->v[c] - dt / 2 * of->acceleration[c];
#else
    if ((fault.written_velocity || rule.written_velocities_whole_step) && c < components) {
        accelerate(of);
        return of->v[c] + dt / 2 * of->acceleration[c];
    }
    return of->v[c];
#endif
}

/* ---- reading and writing a job ---- */

static FILE *opened(const char *folder, const char *name, const char *mode)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, mode);
    if (!file) fail("cannot open %s", path);
    return file;
}

static char *read_all(const char *folder, const char *name)
{
    FILE *file = opened(folder, name, "rb");
    size_t length = 0, got;
    char *text = resized(NULL, 1 << 16, 1);
    while ((got = fread(text + length, 1, 1 << 16, file))) text = resized(text, (length += got) + (1 << 16), 1);
    text[length] = 0;
    fclose(file);
    return text;
}

/* Rebound speed over approach speed of a dashpot that does not pull (Schwager and Pöschel 2007). */
static double clipped_restitution(double ratio)
{
    const double root = sqrt(fabs(1 - ratio * ratio));
    if (root < 1e-6) return exp(-2.0);
    return exp(-ratio / root * (ratio < 1 ? acos(-1.0) - atan2(2 * ratio * root, 1 - 2 * ratio * ratio) : 2 * log(ratio + root)));
}

static double ratio_of(double restitution, bool clipped_formula)
{
    const double logarithm = -log(restitution);
    double low = logarithm / hypot(acos(-1.0), logarithm), high = low;
    if (!clipped_formula || restitution == 1) return low;
    while (clipped_restitution(high) > restitution) high *= 2;
    for (int halving = 0; halving < 100; halving++) {
        const double middle = (low + high) / 2;
        *(clipped_restitution(middle) > restitution ? &low : &high) = middle;
    }
    return low;
}

static void read_model(const char *model)
{
    const char *law = member(model, "law"), *contact = member(law, "contact"), *viscosity = member(contact, "viscosity");
    const char *pull = member(model, "gravity");
    const double seconds = number(model, "dt") * fault.dt, angle = number(law, "friction_angle");
    for (int axis = 0; axis < 2; axis++) gravity[axis] = atof(item(pull, axis)) * fault.gravity * TIME * TIME / LENGTH;
    gravity[0] += fault.gravity_x * fabs(gravity[1]);
    alpha = number(model, "alpha") * fault.alpha;
    dt = seconds / TIME;
    modulus = number(law, "modulus") * TIME * TIME / MASS * LENGTH;
    stiffness_ratio = number(law, "stiffness_ratio");
    friction = angle > 0;
    tan_phi = (fault.tan_phi_is_phi ? angle : tan(angle)) * fault.tan_phi;
    turns = friction && is(contact, "rotation", "free");
    components = turns && !fault.spin_missing ? 3 : 2;
    corrected = is(contact, "slip_velocity", "ratcheting_corrected") != (fault.slip_other != 0);
    if (rule.slip_corrected || rule.slip_contact_point || rule.slip_unstretched) corrected = rule.slip_corrected;
    slips_at_point = !corrected && !rule.slip_unstretched;
    half_overlap = rule.torque_arms_half_overlap
        || (is(contact, "torque_arms", "half_overlap") && !rule.torque_arms_contact_point && !rule.torque_arms_whole_radii);
    whole_step = rule.new_contact_whole_step
        || (is(contact, "new_contact_slip", "whole_step") != (fault.new_contact_other != 0) && !rule.new_contact_since_touch);
    dashpots = !is(viscosity, "kind", "none");
    damping_constant = damping_ratio = 0;
    if (dashpots) {
        clipped = is(viscosity, "tension", "clipped");
        const bool clipped_formula = rule.restitution_cut || (clipped && !rule.restitution_uncut);
        if (is(viscosity, "kind", "dashpot")) damping_constant = number(viscosity, "c_n") * fault.c_n * TIME / MASS;
        else damping_ratio = ratio_of(number(viscosity, "e_n"), clipped_formula);
        if (rule.tension_cut || rule.tension_not_cut) clipped = rule.tension_cut;
        clipped = clipped != (fault.clipping != 0);
    }
    const char *list = member(model, "walls"), *wall;
    for (wall_count = 0; (wall = item(list, wall_count)); wall_count++) {
        walls = resized(walls, wall_count + 1, sizeof *walls);
        walls[wall_count] = (Wall){is(wall, "axis", "z"), number(wall, "place") / LENGTH};
    }
    if (wall_count) walls[wall_count - 1].place += fault.wall_place * mean_radius;
}

/* Whether they have spins. */
static bool read_grains(char *text)
{
    const bool spins = strstr(text, "spin") && strstr(text, "spin") < strchr(text, '\n');
    char *at = strchr(text, '\n') + 1;
    double radii = 0, places = 0;
    for (count = 0; *at; count++) {
        double row[9] = {0};
        for (int column = 0; column < (spins ? 9 : 7); column++) row[column] = strtod(at, &at), at += *at != 0;
        grains = resized(grains, count + 1, sizeof *grains);
        Grain *of = &grains[count];
        *of = (Grain){.x = {row[1] / LENGTH, row[2] / LENGTH}, .given = {row[1], row[2], row[3], row[4], row[7]}};
        for (int axis = 0; axis < 2; axis++) {
            of->old[axis] = of->x[axis];
            of->v[axis] = row[3 + axis] * TIME / LENGTH;
            of->mass[axis] = row[6] * fault.mass / MASS;
        }
        of->v[2] = row[7] * TIME;
        of->mass[2] = row[8] * fault.inertia / (MASS * LENGTH * LENGTH);
        of->radius = row[5] * fault.radius / LENGTH;
        radii += row[5] / LENGTH, places += row[1] / LENGTH;
    }
    mean_radius = radii / count;
    middle = places / count;
    for (int axis = 0; axis < 2; axis++) grains[count / 2].mass[axis] *= fault.mass_one;
    grains[count / 2].radius *= fault.radius_one;
    free(text);
    return spins;
}

static void read_punch(const char *of)
{
    punch.there = *of == '{';
    if (!punch.there) return;
    punch.start = number(of, "start");
    punch.velocity = number(of, "velocity") * fault.punch_speed * TIME / LENGTH;
    for (int axis = 0; axis < 2; axis++) {
        punch.x[axis] = atof(item(member(of, "centre"), axis)) / LENGTH;
        punch.half[axis] = atof(item(member(of, "half_extents"), axis)) / LENGTH;
    }
}

/* ---- writing ---- */

static FILE *lines, *tables;
static bool spins; /* whether the tables have them */

static void put(double number) { fwrite(&number, sizeof number, 1, tables); }

static void write_moment(const char *stage, long step, bool as_given)
{
    for (int column = 0; column < (spins ? 5 : 4); column++)
        for (int id = 0; id < count; id++) {
            Grain *of = &grains[id];
            if (as_given) put(of->given[column]);
            else if (column < 2) put(of->x[column] * LENGTH);
            else if (column < 4) put(half_step_velocity(of, column - 2) * LENGTH / TIME);
            else put(half_step_velocity(of, 2) / TIME);
        }
    for (size_t at = 0; at < contacts.count; at++) {
        const Contact *of = &contacts.of[at];
        const Grain *two = &grains[of->second];
        const double length = hypot((double)of->normal[0], (double)of->normal[1]);
        const double nx = of->normal[0] / length, nz = of->normal[1] / length, newton = MASS * LENGTH / (TIME * TIME);
        const double arm = two->radius - (of->at_wall ? of->overlap : of->overlap / 2);
        put(of->first);
        put(of->second);
        put(of->overlap * LENGTH);
        put((of->force[0] * nx + of->force[1] * nz) * newton);
        put((of->force[1] * nx - of->force[0] * nz) * newton);
        put(nx);
        put(nz);
        put((two->x[0] - arm * nx) * LENGTH);
        put((two->x[1] - arm * nz) * LENGTH);
    }
    fprintf(lines, "{\"stage\": \"%s\", \"step\": %ld, \"contacts\": %zu, \"punch\": ", stage, step, contacts.count);
    if (punch.there)
        fprintf(lines, "{\"centre\": [%.17g, %.17g], \"start\": %.17g, \"velocity\": %.17g, \"force\": %.17g}}\n",
            (double)punch.x[0] * LENGTH, (double)punch.x[1] * LENGTH, punch.start, (double)punch.velocity * LENGTH / TIME,
            punch.force * MASS * LENGTH / (TIME * TIME));
    else fprintf(lines, "null}\n");
}

/* ---- jobs ---- */

/* A punch on the highest grain below it. */
static void lower_punch(const char *loading)
{
    const double axis = number(loading, "axis");
    double top = 0;
    for (int at = 0; at < 2; at++) punch.half[at] = atof(item(member(loading, "half_extents"), at)) / LENGTH;
    for (int id = 0; id < count; id++)
        if (fabs(grains[id].x[0] - axis / LENGTH) < punch.half[0] + grains[id].radius)
            top = fmax(top, (double)(grains[id].x[1] + grains[id].radius));
    punch.there = true;
    punch.x[0] = axis / LENGTH;
    punch.x[1] = top + punch.half[1];
    punch.start = top * LENGTH;
    punch.velocity = -number(loading, "speed") * fault.punch_speed * TIME / LENGTH;
}

/* Does a case, or a scene until a step; the steps that were done. */
static long run(const char *folder)
{
    char *job = read_all(folder, "job.json");
    long steps = 0;
    if (is(job, "kind", "cases")) {
        const char *list = member(job, "folders"), *name;
        for (int index = 0; (name = item(list, index)); index++) {
            char inner[4096];
            snprintf(inner, sizeof inner, "%s/%.*s", folder, (int)strcspn(name + 1, "\""), name + 1);
            steps += run(inner);
        }
        return steps;
    }
    const bool scene = is(job, "kind", "scene");
    const char *stage = scene && is(job, "stage", "load") ? "load" : "settle";
    const long start = scene ? number(job, "step") : 0, every = scene ? number(job, "moments_every") : 1;
    const char *moment = scene ? NULL : item(member(job, "moments"), 0);
    const long until = scene ? number(job, "until_step") : -1;
    spins = read_grains(read_all(folder, "initial.csv"));
    read_model(member(job, "model"));
    read_punch(member(job, "punch"));
    lines = opened(folder, "moments.jsonl", "w");
    tables = opened(folder, "tables.bin", "wb");
    contacts.count = searches = 0;
    first_step = true;
    evaluate_forces();
    finish_kick();
    /* The punch that is lowered now bears no force yet. */
    if (!strcmp(stage, "load") && !punch.there) lower_punch(member(job, "loading"));
    for (long step = start; scene ? step <= until : moment != NULL; step++) {
        if (step > start) step_once(), steps++;
        if (scene ? step == start || step == until || step % every == 0 : step == atol(moment)) {
            write_moment(stage, step, step == start);
            if (moment && *(moment = space(behind(moment))) == ']') moment = NULL;
        }
    }
    const double seconds = (double)clock() / CLOCKS_PER_SEC;
    if (scene)
        fprintf(lines, "{\"end\": \"%s\", \"steps\": %ld, \"stop\": \"steps_done\", \"wall_seconds\": %g, \"cpu_seconds\": %g}\n",
            stage, until, seconds, seconds);
    fclose(lines);
    fclose(tables);
    free(job);
    return steps;
}

int main(int words, char **word)
{
    read_faults();
    rule = read_rules("RULES", (Rules){0});
    declared = read_rules("DECLARED", rule);
    if (words == 2 && !strcmp(word[1], "describe")) {
        describe();
        return 0;
    }
    if (words != 3 || strcmp(word[1], "run")) fail("usage: engine describe | run FOLDER");
    const long steps = run(word[2]);
    FILE *done = opened(word[2], "done.json", "w");
    fprintf(done, "{\"steps\": %ld}\n", steps);
    return fclose(done);
}
