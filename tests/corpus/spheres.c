/* A discrete-element engine of its own for spheres in space, with switches: right and wrong ones on which verdicts are tested.
 *
 * It was written from the documents and shares no code with the native engine. Compiled plainly it does the same operations in
 * the same order, but for contacts that get the slip since their touch.
 *
 *     cc -std=c11 -O2 spheres.c -lm -o spheres
 *     spheres describe | spheres run FOLDER
 *
 * Which right engine it is, is chosen when it is compiled; each of these is right but for rounding:
 *
 *     -DREAL="long double"   type of the state
 *     -DFORCE="long double"  type of contacts, forces and their sums, computed from differences of places
 *     -DREVERSED             forces on a grain summed from the last contact to the first
 *     -DPAIRWISE             forces on a grain collected and summed pairwise
 *     -DKAHAN                forces summed with a compensation
 *     -DRECIPROCAL           x*(1/d) instead of x/d
 *     -DVERLET               velocity Verlet, with the velocities at whole steps inside
 *     -DCOMPLIANCES          moduli, radii, masses and springs in series by their reciprocals
 *     -DROOTS                u*sqrt(u) instead of pow(u, 1.5)
 *     -DHYPOT                distances by hypot
 *     -DUNITS                units of its own inside
 *     -DAXES                 axes in another order inside
 *     -DRENUMBERED           the last grain is the first inside, and each pair is seen from its other grain
 *     -DALL_PAIRS            all pairs are looked at, without cells
 *     -DTABLES               writes CSV tables
 *
 * Which wrong engine it is, is chosen when it runs: by the variable FAULT, such as FAULT="k_n=1.05,history_reset", or by what
 * stands behind "--" in the name of the program, such as "spheres--k_n=1.05". A fault without a number is 1. The names are
 * FACTORS and FAULTS below; one that is unknown ends the program. spheres.json lists them.
 *
 * museum=N makes the fault that a real code had, number N of museum.json; 100 + N is the other half of a number that has two.
 *
 * A job in the plane is one in space where nothing leaves y = 0.
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

#ifdef AXES
enum { Z, X, Y }; /* the same sense of turning */
#else
enum { X, Y, Z };
#endif
#define AXIS(number) ((number) == 1 ? X : (number) == 2 ? Y : Z)

/* What SI units are counted in inside. */
#ifdef UNITS
static const double LENGTH = 0.0047, TIME = 3.1e-5, MASS = 0.19;
#else
static const double LENGTH = 1, TIME = 1, MASS = 1;
#endif

/* Numbers that are 1 in a right engine: constants are multiplied by them. */
#define FACTORS                                                                                                        \
    X(k_n) X(k_s) X(k_n_grain) X(k_n_wall) X(k_n_punch) X(modulus) X(poisson) X(tan_phi) X(c_n) X(c_s) X(alpha)        \
    X(gravity) X(dt) X(mass) X(inertia) X(radius) X(bending) X(twisting) X(rolling_limit) X(adhesion) X(punch_speed)   \
    X(first_kick) X(damping_velocity) X(hertz_exponent)

/* Numbers that are 0 in a right engine. An axis is 1 for x, 2 for y, 3 for z. */
#define FAULTS                                                                                                         \
    X(effective_modulus)   /* 1: of 1-v instead of 1-v^2; 2: the mean of both; 3: without v */                          \
    X(shear_modulus)       /* 1: E/2(1-v); 2: 1/(1/G+1/G); 3: of 1-v instead of 2-v; 4: of the first alone */           \
    X(effective_radius)    /* 1: the mean; 2: twice as large; 3: the smaller radius */                                 \
    X(radius_at_walls)     /* 1: R* = R at walls and punch; 2: two thirds of R */                                      \
    X(stiffness_mean)      /* of linear springs, 1: arithmetic; 2: half as large; 3: that of the first */               \
    X(spring_secant)       /* k_n is force over overlap for dashpots */                                                \
    X(shear_secant)        /* k_s is of the overlap a radius has, not of this one */                                   \
    X(mass_at_walls)       /* 1: m/2 instead of m; 2: 2m */                                                            \
    X(effective_mass)      /* 1: the mean; 2: the sum; 3: that of the second; 4: the smaller */                        \
    X(restitution_formula) /* 1: -ln e/sqrt(pi^2+ln^2 e); 2: -ln e/pi; 3: 1-e */                                       \
    X(dashpot_half)        /* c = b sqrt(m k) without the 2 */                                                         \
    X(dashpot_whole_velocity) /* the normal dashpot brakes all of the velocity */                                      \
    X(dashpot_corrected)   /* the normal dashpot gets the stretched slip velocity */                                   \
    X(clipping)            /* the other way */                                                                         \
    X(shear_dashpot)       /* 1: none; 2: limited together with the spring; 3: of k_n; 4: also while sliding; */ \
                           /* 5: of the whole velocity; 6: in the first step alone */                                 \
    X(history_reset)                                                                                                   \
    X(history_late)        /* reset after so many steps: no first steps show it */                                     \
    X(pushed_at)           /* the first grain is pushed in this step, at no other */                                   \
    X(history_not_turned) X(history_turned_back)                                                      \
    X(history_turned_late) /* after the slip is added */                                                               \
    X(history_twist)       /* about the normal, 1: not; 2: back; 3: twice; 4: by the first spin alone */                \
    X(history_projected)   /* projected instead of turned */                                                           \
    X(history_sliding)     /* after sliding, 1: nothing is kept; 2: all of it is */                                    \
    X(history_at_walls)    /* none there */                                                                            \
    X(history_displacement) /* the spring keeps 1: a displacement; 2: one that shrinks with the contact; 3: such a force */ \
    X(new_contact)         /* 1: no slip in its first step; 2: half of it; 3: not capped */                              \
    X(coulomb)             /* 1: none; 2: each component by itself; 3: of the spring; 4: of the pull too, or not */     \
    X(tan_phi_is_phi)                                                                                                  \
    X(friction_of)         /* 1: the larger angle; 2: that of the first; 3: the mean; 4: of the tangents */            \
    X(friction_at_walls)   /* 1: that of grains; 2: the punch has that of walls */                                     \
    X(slip_other) X(slip_not_stretched) X(slip_without_spin) X(slip_spin_sign)                                         \
    X(slip_axis)           /* this component is left out */                                                            \
    X(rolling)             /* 1: none; 2: other sign; 3: on one grain; 4: not at walls; 5: of the sum of spins */       \
    X(rolling_kept)        /* 1: not turned; 2: reset; 3: kept without its limit */                                    \
    X(rolling_radius)      /* limit by 1: R*; 2: the sum; 3: the first radius */                                       \
    X(rolling_cap)         /* 1: none; 2: with twisting together; 3: of the spring */                                  \
    X(twist)               /* 1: none; 2: bending's stiffness; 3: limited; 4: not turned; 5: other sign; 6: none at walls */ \
    X(moment_of_spin)      /* multiplied by the spin, in rad/s, 1: the limit of bending; 2: twisting */                 \
    X(adhesion_radius)     /* 1: the sum; 2: the smaller; 3: the mean; 4: geometric */                                               \
    X(adhesion_missing)    /* 1: at walls and punch; 2: of pairs */                                                    \
    X(adhesion_push)                                                                                                   \
    X(dmt)                 /* the limit has 1: one pull, as |N| + A; 2: the dashpot; 3: clipped as another law's */       \
    X(jkr)                 /* 1: ends with the surfaces; 2: begins at the largest pull; 3: a = sqrt(R*u) of k_n and k_s; */ \
                           /* 4: limit of F alone; 5: pull of 4 pi; 6: w = gamma, not 2 gamma; 7: ends where it breaks; 8: at half */ \
    X(moment_rules)        /* of moments 1: the force turns, limits as friction has, none at walls; 2: a constant */      \
                           /* torque is limited by the spring and weaker where grains twist */                         \
    X(declares)            /* rules, 1 to 3: spring_memory as history_displacement; 4: flat walls; 5: both 1 and 4; */      \
                           /* 6 and 7: moment_rules */                                                                       \
    X(torque_arms)         /* 1: R; 2: R at walls; 3: R-u; 4: the other way */                                         \
    X(torque_other)        /* 1: other sign on the second; 2: none on the second; 3: none at walls; 4: of the whole */  \
    X(torque_axis) X(force_axis) X(velocity_axis) X(damping_axis) /* left out */                                       \
    X(spin_axis)           /* left out of velocities at contacts */          \
    X(cross_sign)          /* of this component of torques */                                                          \
    X(gravity_axis)        /* gravity along this axis */                                                               \
    X(damping_off_spin) X(damping_off_gravity) X(damping_together) X(third_law) X(drift_late) X(spin_blocked)          \
    X(written_velocity)    /* velocities are written of the whole step */                                              \
    X(wall_missing)        /* the first wall, the second, ... */                                                       \
    X(wall_place)          /* the last wall is so many mean radii inside */                                            \
    X(wall_one_sided)      /* normals at walls point along the axis */                                                 \
    X(wall_overlap)        /* of the diameter at the last wall */                                                      \
    X(punch_missing) X(punch_corners) X(punch_short) X(punch_late) X(punch_standing) X(punch_corrected)                \
    X(material_ignored)    /* 1: all have the first; 2: pairs have the first grain's; 3: walls have the grain's */             \
    X(mass_of_disc)        /* of a cylinder as high as the sphere */                                                   \
    X(inertia_of_disc)     /* 1: half of mR^2; 2: that about y alone */                                                \
    X(pairs_missed)        /* 1: cells beside along y are not searched; 2: one of them; 3: above; 4: far ones along y */ \
    X(pairs_most)          /* 1: the list of pairs ends after 150; 2: a grain has 3 with higher ids; 3: none with ids beyond 24 apart; */ \
                           /* 4: none has a first id of 128 or more; 5: a grain has 3 with lower ids */               \
    X(history_stays)       /* 1: what ended goes on where it touches again; 2: every 4 steps all is forgotten; 3: k_s stays the first; */ \
                           /* 4: a grain's first contact hands its memory to a new one; 5: it forgets where the number of contacts changed; */ \
                           /* 6: as 1, of the moment against rolling alone */                                         \
    X(single)              /* in single precision are 1: the normal spring; 2: sums of forces; 3: dashpots; 4: what slip adds; 5: torques */ \
    X(one_of_two)          /* 1: k_s of the smaller radius; 2: E* of the first one's v; 3: mass in c_s the first's; */ \
                           /* 4: the rolling limit has the second's radius; 5: G* of the second's v; 6: mass in c_s the second's */ \
    X(damping_spins)       /* 1: together; 2: by the velocities' sign; 3: half as much */                              \
    X(slows)               /* 1: tan phi falls with the slip velocity; 2: k_n with the radii apart */                  \
    X(pairs_every)         /* the search comes every so many steps, without a margin */                                \
    X(pairs_twice)         /* pairs across the middle of y */                                                          \
    X(table_point) X(table_normal) X(table_tangent) /* this component, 1: x, 2: y, 3: z, has the other sign */          \
    X(table_tangent_size)  /* ft is the component across, as in the plane */                                           \
    X(table_first)         /* forces on the first body are written */                                                  \
    X(table_spring)        /* fn is the spring's */                                                                    \
    X(table_missing)       /* 1: of front and back; 2: the last one; 3: where the force is nothing or pulls */          \
    X(table_order)         /* 1: backwards; 2: higher id first; 3: front and back exchanged */                         \
    X(table_wall_point)    /* half an overlap above the wall */                                                        \
    X(table_overlap)       /* half of it */                                                                            \
    X(table_spins)         /* spins about x and z exchanged */                                                         \
    X(table_velocity)      /* y is written as it was a step ago */                                                     \
    X(museum)              /* what a real code had: a number of museum.json */                                         \
    X(plane_refused)       /* 1: what is in the plane is refused, though it is a part */                               \
    X(parts)               /* declared, with any fault, are 1: those of the plane alone; 2: space without the plane */

static struct {
#define X(name) double name;
    FACTORS FAULTS
#undef X
} fault = {
#define X(name) .name = 1,
    FACTORS
#undef X
};

static bool museum(int number) { return fault.museum == number; }

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

/* Since the program began. */
static long steps_made;

static void read_faults(const char *at)
{
    static const struct { const char *name; double *value; } known[] = {
#define X(name) {#name, &fault.name},
        FACTORS FAULTS
#undef X
    };
    while (at && *at) {
        size_t length = strcspn(at, "=,"), index = 0, most = sizeof known / sizeof *known;
        while (index < most && (strlen(known[index].name) != length || strncmp(known[index].name, at, length))) index++;
        if (index == most) fail("no such fault: %s", at);
        *known[index].value = at[length] == '=' ? atof(at + length + 1) : 1;
        at += strcspn(at, ",");
        at += *at == ',';
    }
    if (museum(4)) fault.mass_at_walls = 1;
    if (museum(12)) fault.coulomb = 3;
    if (museum(22)) fault.history_displacement = 1;
    if (museum(110)) fault.shear_dashpot = 4;
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

/* NULL if it is not there, or null. */
static const char *given(const char *object, const char *name)
{
    size_t length = strlen(name);
    for (const char *at = space(object + 1); *at == '"'; at = space(behind(space(behind(at)))))
        if (!strncmp(at + 1, name, length) && at[length + 1] == '"') {
            const char *value = space(behind(at));
            return *value == 'n' ? NULL : value;
        }
    return NULL;
}

static const char *member(const char *object, const char *name)
{
    const char *value = given(object, name);
    if (!value) fail("the job has no %s", name);
    return value;
}

/* NULL behind the last one. */
static const char *item(const char *list, int index)
{
    const char *at = space(list + 1);
    while (index-- && *at != ']') at = space(behind(at));
    return *at == ']' ? NULL : at;
}

static double number(const char *object, const char *name) { return atof(member(object, name)); }

static double number_or(const char *object, const char *name, double other)
{
    const char *value = given(object, name);
    return value ? atof(value) : other;
}

static bool is(const char *object, const char *name, const char *text)
{
    const char *at = given(object, name);
    return at && !strncmp(at + 1, text, strlen(text)) && at[strlen(text) + 1] == '"';
}

/* ---- vectors ---- */

typedef struct { local of[3]; } V;

static local dot(V a, V b) { return a.of[0] * b.of[0] + (a.of[1] * b.of[1] + a.of[2] * b.of[2]); }
static V times(local f, V a) { return (V){{f * a.of[0], f * a.of[1], f * a.of[2]}}; }
static V plus(V a, V b) { return (V){{a.of[0] + b.of[0], a.of[1] + b.of[1], a.of[2] + b.of[2]}}; }
static V minus(V a, V b) { return (V){{a.of[0] - b.of[0], a.of[1] - b.of[1], a.of[2] - b.of[2]}}; }
static V over(V a, local d) { return (V){{OVER(a.of[0], d), OVER(a.of[1], d), OVER(a.of[2], d)}}; }
static V of_reals(const real *of) { return (V){{of[0], of[1], of[2]}}; }

static V cross(V a, V b)
{
    const local *p = a.of, *q = b.of;
    return (V){{p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]}};
}

static local size(V a)
{
#ifdef HYPOT
    return hypot(hypot(a.of[0], a.of[1]), a.of[2]);
#else
    return sqrt(dot(a, a));
#endif
}

/* Half of the harmonic mean. */
static local in_series(local a, local b)
{
#ifdef COMPLIANCES
    return 1 / (1 / a + 1 / b);
#else
    return OVER(a * b, a + b);
#endif
}

/* ---- state and constants ---- */

/* Components of velocities: along three axes, then about them. */
typedef struct {
    real x[3], v[6], acceleration[6], mass[6], radius;
    local load[6], lost[6];
    int material;
    double given[14]; /* as in NAMES */
    real before[3];
} Grain;

/* Force and torques are on the second body, always a grain; the first one bears the opposite force. */
typedef struct {
    int first, second;
    bool inside_punch;
    V normal, point, shear, bending, twisting, force, tangent, torques[2], moment;
    V slip, stuck, told; /* for the museum: the slip velocity, the tangential force when it last stuck, what is written as force */
    local overlap, spring, apart, k_s, least; /* and the overlap at which it ends */
} Contact;

typedef struct { Contact *of; size_t count, room; } List; /* by rising ids */
typedef struct { int first, second; } Pair;
typedef struct { int axis; real place; } Wall;
typedef struct { local modulus, stiffness_ratio, poisson, friction; } Material;

static Grain *grains;
static int count;
static Wall *walls;
static int wall_count;
static struct { bool there; real x[3], half[3], velocity; double start, force; } punch;
static List contacts, before; /* of this step and of the step before */
static Pair *pairs;           /* of grains that may touch, by rising ids */
static size_t pair_count, pair_room;
static int searches, evaluations;
static bool first_step, in_space, spins;

static real gravity[6], alpha, dt, mean_radius, middle;
static Material *materials; /* the first one is that of the law */
static double wall_friction, punch_friction; /* below 0: none of their own */
static local damping_constant, damping_ratio, shear_ratio, surface_energy, bending_stiffness, twisting_stiffness, rolling_limit;
static enum { PULL, DMT, JKR } adheres;
static bool friction, rotates, hertz, dashpots, clipped, corrected, half_overlap, whole_step, rolling, constant_torque;

/* ---- where bodies touch ---- */

/* The overlap from which on the pair touches that is looked at. */
static local held;

static bool touches_grain(Contact *of)
{
    const Grain *one = &grains[of->first], *two = &grains[of->second];
    const V a = of_reals(one->x);
    V apart;
    for (int axis = 0; axis < 3; axis++) apart.of[axis] = two->x[axis] - one->x[axis];
    const local distance = size(apart);
    of->overlap = (local)(one->radius + two->radius) - distance;
    of->normal = over(apart, distance);
    of->point = plus(a, times(one->radius - (local)0.5 * of->overlap, of->normal));
    if (museum(25) && distance * distance * LENGTH * LENGTH >= 1000) return false;
    return of->overlap >= held && !(fault.pairs_missed == 4 && fabs(apart.of[Y]) > (local)0.9 * (one->radius + two->radius));
}

static bool touches_wall(Contact *of)
{
    const int index = of->first - count, axis = walls[index].axis;
    const Grain *two = &grains[of->second];
    const local distance = two->x[axis] - walls[index].place;
    of->overlap = -(fabs(distance) - two->radius);
    if (fault.wall_overlap && index == wall_count - 1) of->overlap += two->radius * (local)0.01;
    of->normal.of[axis] = distance > 0 || fault.wall_one_sided ? 1 : -1;
    of->point = of_reals(two->x);
    of->point.of[axis] = walls[index].place;
    if (museum(25) && !(fabs(distance) * LENGTH < 1.0)) return false;
    return of->overlap >= held && fault.wall_missing != index + 1;
}

/* The punch is endless along y. */
static bool touches_punch(Contact *of)
{
    static const int across[2] = {X, Z};
    const Grain *two = &grains[of->second];
    const local radius = two->radius;
    V inner = {{0}}, relative = {{0}};
    for (int at = 0; at < 2; at++) {
        const int axis = across[at];
        const local half = punch.half[axis];
        relative.of[axis] = two->x[axis] - punch.x[axis];
        inner.of[axis] = fmin(fmax(relative.of[axis], -half), half);
    }
    if (fault.punch_short && fabs(two->x[Y] - middle) > punch.half[X]) return false;
    V centre = of_reals(two->x), of_punch = {{0}};
    of_punch.of[X] = punch.x[X], of_punch.of[Y] = two->x[Y], of_punch.of[Z] = punch.x[Z];
    if (inner.of[X] != relative.of[X] || inner.of[Z] != relative.of[Z]) {
        const V toward = minus(inner, relative);
        const local distance = size(toward);
        const V b = over(toward, distance);
        of->overlap = radius - distance;
        of->normal = times(-1, b);
        of->point = times(0.5, plus(plus(inner, of_punch), plus(centre, times(radius, b))));
        const bool corner = toward.of[X] != 0 && toward.of[Z] != 0;
        return of->overlap >= held && !(corner && fault.punch_corners);
    }
    const local free_x = punch.half[X] - fabs(relative.of[X]), free_z = punch.half[Z] - fabs(relative.of[Z]);
    const int axis = free_z < free_x ? Z : X;
    V out = {{0}};
    out.of[axis] = relative.of[axis] > 0 ? 1 : -1;
    const V one = plus(centre, times(axis == X ? free_x : free_z, out)), other = minus(centre, times(radius, out));
    const V through = minus(one, other);
    of->inside_punch = true;
    of->overlap = size(through);
    of->normal = over(through, of->overlap);
    of->point = times(0.5, plus(one, other));
    return true;
}

/* ---- the law of a contact ---- */

/* Turns with the contact what it remembers: with the normal first, then about it with both grains. */
static V turned(V was, V old, V now, V spin1, V spin2)
{
    V about = cross(old, now), both = plus(spin1, spin2);
    if (fault.history_turned_back) about = times(-1, about);
    if (fault.history_twist == 4) both = spin1;
    const double twist = fault.history_twist == 1 ? 0 : fault.history_twist == 2 ? -1 : fault.history_twist == 3 ? 2 : 1;
    if (fault.history_projected) return minus(was, times(dot(was, now), now));
    was = minus(was, cross(was, about));
    return minus(was, cross(was, times((local)(0.5 * dt * twist) * dot(old, both), old)));
}

static local root(local u)
{
#ifdef ROOTS
    return sqrt(u);
#else
    return pow(u, (local)(0.5 * fault.hertz_exponent));
#endif
}

static local root_cubed(local u)
{
#ifdef ROOTS
    return u * sqrt(u);
#else
    return pow(u, (local)(1.5 * fault.hertz_exponent));
#endif
}

/* A tangential spring, turned as two codes of the museum do. */
static V turned_spring(V was, const Contact *old, V now, V spin1, V spin2)
{
    const bool flat = old->first >= count;
    if (museum(24) && hertz && flat) return was;
    if (!museum(15) && !(museum(24) && hertz)) return turned(was, old->normal, now, spin1, spin2);
    const V left = minus(was, times(dot(was, now), now));
    return museum(15) && size(left) > 0 ? times(size(was) / size(left), left) : left;
}

/* The radius of a contact by Johnson, Kendall and Roberts: a root of a^4 - 2 R u a^2 - 4 pi g R^2/E a + R^2 u^2 (Ferrari's way). */
static local contact_radius(local radius, local modulus, local energy, local u)
{
    const local k = radius * u, q = 4 * acos((local)-1) * energy * radius * radius / modulus;
    if (!(q > 0)) return sqrt(k);
    const local half = (local)8 / 27 * k * k * k + q * q / 16;
    const local third = cbrt(half + q / 4 * sqrt((local)16 / 27 * k * k * k + q * q / 16));
    const local s = (local)5 / 3 * k + third + (local)4 / 9 * k * k / third, w = sqrt(2 * (s - k));
    return (w + sqrt(w * w - 4 * (s - 2 * k - q / (2 * w)))) / 2;
}

typedef struct { local radius, normal, shear; } Stiffness;

/* Of linear springs k_n and k_s, of Hertz's what u^1.5 and u^0.5 are multiplied by; R* with them. */
static Stiffness stiffness(const Material *a, const Material *b, local r1, local r2, bool flat)
{
    Stiffness of = {in_series(r1, r2), 0, 0};
    if (fault.effective_radius == 1) of.radius = (r1 + r2) / 2;
    if (fault.effective_radius == 2) of.radius *= 2;
    if (fault.effective_radius == 3) of.radius = r1 < r2 ? r1 : r2;
    if (flat && fault.radius_at_walls) of.radius *= fault.radius_at_walls == 1 ? 2 : (local)4 / 3;
    if (!hertz) {
        const local k1 = a->modulus * r1, k2 = b->modulus * r2, s1 = k1 * a->stiffness_ratio, s2 = k2 * b->stiffness_ratio;
        of.normal = dashpots || fault.stiffness_mean ? 1 / (1 / (2 * k1) + 1 / (2 * k2)) : OVER(2 * k1 * k2, k1 + k2);
        of.shear = dashpots ? 1 / (1 / (2 * s1) + 1 / (2 * s2)) : OVER(2 * s1 * s2, s1 + s2);
        if (fault.stiffness_mean == 1) of.normal = (k1 + k2) / 2;
        if (fault.stiffness_mean == 2) of.normal /= 2;
        if (fault.stiffness_mean == 3) of.normal = k1;
        return of;
    }
    const local va = a->poisson, vb = b->poisson, ea = a->modulus, eb = b->modulus;
    const local sign = fault.shear_modulus == 1 ? -1 : 1;
    const local ga = OVER(ea, 2 * (1 + sign * va)), gb = OVER(eb, 2 * (1 + sign * vb));
    const local two = fault.shear_modulus == 3 ? 1 : 2;
    local plane1 = 1 - va * va, plane2 = 1 - vb * vb;
    if (fault.effective_modulus == 1) plane1 = 1 - va, plane2 = 1 - vb;
    if (fault.one_of_two == 2) plane2 = plane1;
    if (fault.effective_modulus == 3) plane1 = plane2 = 1;
#ifdef COMPLIANCES
    local whole = 1 / (plane1 / ea + plane2 / eb);
#else
    local whole = OVER(ea * eb, plane1 * eb + plane2 * ea);
#endif
    if (fault.effective_modulus == 2) whole = (ea / plane1 + eb / plane2) / 4;
    local shear = 1 / (OVER(two - va, ga) + OVER(two - vb, gb));
    if (fault.one_of_two == 5) shear = 1 / (OVER(two - vb, OVER(ea, 2 * (1 + vb))) + OVER(two - vb, gb));
    if (fault.shear_modulus == 2) shear = in_series(ga, gb);
    if (fault.shear_modulus == 4) shear = ga / (2 * (2 - va));
    of.normal = ((local)4 / 3) * whole * sqrt(of.radius);
    of.shear = (8 * shear) * sqrt(of.radius);
    return of;
}

/* The one in c = 2 beta sqrt(m k). */
static local effective_mass(const Contact *of)
{
    const local two = grains[of->second].mass[0];
    if (of->first >= count) return fault.mass_at_walls == 1 ? two / 2 : fault.mass_at_walls == 2 ? 2 * two : two;
    const local one = grains[of->first].mass[0];
    if (fault.effective_mass == 4) return fmin(one, two);
    if (fault.effective_mass) return fault.effective_mass == 1 ? (one + two) / 2 : fault.effective_mass == 2 ? one + two : two;
    return in_series(one, two);
}

static double tan_of(double angle) { return (fault.tan_phi_is_phi ? angle : tan(angle)) * fault.tan_phi; }

static local tan_phi(const Contact *of, const Material *a, const Material *b)
{
    const bool of_punch = of->first == count + wall_count;
    double angle = fmin((double)a->friction, (double)b->friction);
    if (fault.friction_of == 1) angle = fmax((double)a->friction, (double)b->friction);
    if (fault.friction_of == 2) angle = a->friction;
    if (fault.friction_of == 4) angle = atan((tan((double)a->friction) + tan((double)b->friction)) / 2);
    if (fault.friction_of == 3) angle = (a->friction + b->friction) / 2;
    const double own = of_punch && fault.friction_at_walls != 2 ? punch_friction : wall_friction;
    if (of->first >= count && own >= 0 && fault.friction_at_walls != 1) angle = own;
    return tan_of(angle);
}

/* No longer than the limit, of which the square is given too; whether it was longer. */
static bool cut(V *vector, local limit, local squared)
{
    const local length = dot(*vector, *vector);
    if (fault.coulomb == 2)
        for (int axis = 0; axis < 3; axis++)
            if (fabs(vector->of[axis]) > limit) vector->of[axis] = copysign(limit, vector->of[axis]);
    if (fault.coulomb == 1 || fault.coulomb == 2 || !(length > squared)) return false;
    *vector = times(OVER(limit, sqrt(length)), *vector);
    return true;
}

/* What a pair had when its last contact ended. */
static List gone;

static const Contact *ended_of(const Contact *of)
{
    for (size_t at = gone.count; at-- > 0;)
        if (gone.of[at].first == of->first && gone.of[at].second == of->second) return &gone.of[at];
    return NULL;
}

/* What the contact does in this step; `old` is the same contact a step before, if it was there. */
static void act(Contact *of, const Contact *old)
{
    static const Grain still;
    Grain flat_body = still;
    const bool flat = of->first >= count, of_punch = of->first == count + wall_count;
    const Grain *two = &grains[of->second], *one = flat ? &flat_body : &grains[of->first];
    const local r2 = two->radius, r1 = flat ? r2 : (local)one->radius, u = of->overlap;
    const Material *b = &materials[two->material], *a = &materials[flat ? 0 : one->material];
    if (flat && fault.material_ignored == 3) a = b;
    if (fault.material_ignored == 2) b = a;
    V spin1, spin2 = of_reals(two->v + 3);
    if (of_punch && !fault.punch_standing) flat_body.v[Z] = punch.velocity;
    const V n = of->normal, x1 = of_reals(one->x), x2 = of_reals(two->x), v1 = of_reals(one->v), v2 = of_reals(two->v);
    spin1 = of_reals(one->v + 3);
    if (fault.spin_axis) spin1.of[AXIS(fault.spin_axis)] = spin2.of[AXIS(fault.spin_axis)] = 0;
    Stiffness k = stiffness(a, b, r1, r2, flat);
    const local scale = (local)(fault.k_n * (flat ? of_punch ? fault.k_n_punch : fault.k_n_wall : fault.k_n_grain));

    /* Velocities of the second surface along the first: at the point of contact, and as slip. */
    V arm1 = flat ? (V){{0}} : minus(of->point, x1), arm2 = minus(of->point, x2);
    const V velocity = minus(plus(v2, cross(spin2, arm2)), plus(v1, cross(spin1, arm1)));
    bool correct = corrected != (fault.slip_other != 0);
    if (of_punch) correct = (of->inside_punch && (hertz || !dashpots)) || fault.punch_corrected;
    V relative = velocity;
    if (correct) {
        const local stretch = fault.slip_not_stretched ? 1 : OVER(r1 + r2, r1 + r2 - u);
        relative = minus(plus(times(stretch, minus(v2, v1)), cross(spin2, times(-r2, n))), cross(spin1, times(r1, n)));
    }
    if (fault.slip_without_spin) relative = minus(v2, v1);
    if (fault.slip_spin_sign || (flat && museum(120))) relative = minus(times(2, minus(v2, v1)), relative);
    V slip = minus(relative, times(dot(n, relative), n));
    if (fault.slip_axis) slip.of[AXIS(fault.slip_axis)] = 0;

    /* Along the normal. */
    const local pi = acos((local)-1), energy = surface_energy / (fault.jkr == 6 ? 2 : 1);
    const local modulus = (local)0.75 * k.normal * scale / sqrt(k.radius);
    local along = 0, reach = 0;
    if (hertz && adheres == JKR) {
        along = reach = contact_radius(k.radius, modulus, energy, u);
        of->least = -pow(9 * pi * energy * k.radius * k.radius / (4 * modulus), (local)2 / 3) / (3 * k.radius);
        if (fault.jkr == 1) of->least = 0;
        if (fault.jkr == 8) of->least /= 2;
        if (fault.jkr == 7) of->least *= pow((local)9, (local)1 / 3);
        along /= sqrt(k.radius);
        if (fault.jkr == 3) along = root(u > 0 ? u : 0);
    } else if (hertz) along = root(u);
    if (fault.slows == 2) k.normal *= sqrt(fmin(r1, r2) / fmax(r1, r2));
    const local k_n = hertz ? ((local)1.5 * k.normal * scale) * along : k.normal * scale;
    local k_s_now = (hertz ? k.shear * (fault.shear_secant ? root((local)0.01 * r2) : along) : k.shear) * (local)fault.k_s;
    if (fault.one_of_two == 1) k_s_now *= hertz ? sqrt(fmin(r1, r2) / k.radius) : fmin(r1, r2) / (2 * k.radius);
    local k_s = fault.history_stays == 3 && old ? old->k_s : k_s_now;
    if (museum(1) && flat && !hertz) k_s *= sqrt(u * r2) * (local)LENGTH;
    local pull_radius = k.radius, pull = 0, spring = hertz ? adheres == JKR ? 0 : k.normal * scale * root_cubed(u) : k_n * u;
    if (fault.adhesion_radius) pull_radius = fault.adhesion_radius == 2 ? fmin(r1, r2) : r1 + r2;
    if (fault.adhesion_radius == 4) pull_radius = sqrt(r1 * r2) / 2;
    if (fault.adhesion_radius == 3) pull_radius /= 2;
    const local share = hertz && adheres == JKR && fault.jkr != 5 ? 3 : 4;
    if (fault.adhesion_missing != (flat ? 1 : 2)) pull = share * pi * pull_radius * energy;
    if (hertz && adheres == JKR)
        spring = 4 * modulus * reach * reach * reach / (3 * k.radius) - 4 * reach * sqrt(pi * energy * modulus * reach) + pull;
    if (fault.single == 1 && adheres != JKR) spring = (float)k.normal * (float)scale * (hertz ? powf(u, 1.5f) : (float)u);
    const local elastic = fault.adhesion_push ? spring + pull : spring - pull, mass = effective_mass(of);
    const local factor = fault.dashpot_half ? 1 : 2, braked = dot(n, fault.dashpot_corrected ? relative : velocity);
    local c_n = damping_constant, c_s = 0;
    if (dashpots && damping_constant == 0) {
        const local of_force = museum(23) && hertz && adheres != JKR ? (local)1.5 * fabs(elastic) / u : k_n;
        c_n = factor * damping_ratio * sqrt(mass * (fault.spring_secant && hertz ? spring / u : of_force)) * (local)fault.c_n;
        if (hertz) c_s = factor * shear_ratio * sqrt((fault.one_of_two == 3 && !flat ? grains[of->first].mass[0] : fault.one_of_two == 6 ? grains[of->second].mass[0] : mass) * (fault.shear_dashpot == 3 ? k_n : k_s)) * (local)fault.c_s;
    }
    if (fault.single == 3) c_n = (float)c_n;
    V normal = times(elastic, n);
    if (dashpots && !hertz) {
        const local both = elastic - c_n * braked;
        normal = times(both < 0 && clipped ? 0 : both, n);
    } else if (dashpots) {
        const V viscous = times(c_n, times(braked, n)), both = minus(normal, viscous);
        if (!clipped || dot(both, n) >= 0 || (adheres && fault.dmt != 3)) normal = both;
        else if (pull == 0) normal = (V){{0}};
        else normal = size(viscous) > pull ? minus(normal, times(pull, over(viscous, size(viscous)))) : both;
    }
    const local pressure = size(normal);

    /* Along the tangent. */
    V kept = {{0}}, sideways = {{0}}, elastic_sideways = {{0}};
    const bool late = fault.history_late && steps_made > fault.history_late;
    static Contact again;
    if (!old && fault.history_stays == 1 && ended_of(of)) again = *ended_of(of), old = &again, again.normal = of->normal;
    if (!old && fault.history_stays == 4 && !flat && before.count && before.of[0].first == of->first) again = before.of[0], old = &again;
    if (fault.history_stays == 2 && evaluations % 4 == 0) old = NULL;
    const bool remembers = old && !late && !fault.history_reset && !(flat && fault.history_at_walls);
    if (friction) {
        const local approach = -dot(n, relative);
        local time = dt;
        if (!old && !whole_step && approach * time > u) time = OVER(u, approach);
        if (!old && fault.new_contact) time = fault.new_contact == 1 ? 0 : fault.new_contact == 3 ? OVER(u, approach) : time / 2;
        V added = hertz || !dashpots ? times(k_s, times(time, slip)) : times(k_s * time, slip);
        if (fault.single == 4) for (int axis = 0; axis < 3; axis++) added.of[axis] = (float)added.of[axis];
        if (museum(13)) added = remembers ? times(k_s * time, old->slip) : (V){{0}};
        if (museum(2) && flat && !hertz) added = times(c_n / c_n, added);
        if (remembers) kept = old->shear;
        if (remembers && fault.history_displacement) {
            const local growth = k_s / old->k_s, shrinks = fmin(growth, (local)1);
            kept = times(fault.history_displacement == 3 ? shrinks : growth * (fault.history_displacement == 2 ? shrinks : 1), kept);
        }
        if (fault.history_turned_late) kept = minus(kept, added), added = (V){{0}};
        if (remembers && !fault.history_not_turned) kept = turned_spring(kept, old, n, spin1, spin2);
        kept = minus(kept, added);
        local tangent = tan_phi(of, a, b);
        if (fault.slows == 1) tangent /= 1 + size(slip) * (local)(LENGTH / TIME);
        local force = fault.coulomb == 3 ? spring : fault.coulomb == 4 ? pressure : pressure + pull;
        if (adheres && !fault.coulomb && fault.dmt != 1) force = fault.dmt == 2 ? fabs(dot(normal, n) + 2 * pull) : fabs(spring + pull);
        if (adheres == JKR && fault.jkr == 4) force = fabs(elastic);
        local limit = force * tangent, squared = limit * limit;
        if (!hertz && fault.coulomb != 3) squared = dot(normal, normal) * (tangent * tangent), limit = sqrt(squared);
        const V dashpot = times(fault.shear_dashpot == 1 || (fault.shear_dashpot == 6 && old) ? 0 : c_s, over(times(dt, fault.shear_dashpot == 5 ? relative : slip), dt));
        if (museum(9)) kept = minus(kept, dashpot);
        const V uncut = kept;
        sideways = fault.shear_dashpot == 2 ? minus(kept, dashpot) : kept;
        cut(&sideways, limit, squared);
        const bool slides = cut(&kept, limit, squared);
        if (c_s != 0 && fault.shear_dashpot != 2 && (!slides || fault.shear_dashpot == 4) && !museum(9))
            sideways = minus(sideways, dashpot);
        if (slides && fault.history_sliding) kept = fault.history_sliding == 1 ? (V){{0}} : uncut;
        elastic_sideways = kept;
        if (museum(10) && slides) sideways = old ? old->stuck : (V){{0}};
        of->stuck = sideways;
        of->slip = slip;
        if (museum(11)) {
            sideways = minus(uncut, dashpot);
            kept = cut(&sideways, limit, squared) ? plus(sideways, dashpot) : uncut;
        }
    }
    of->shear = kept;
    of->k_s = k_s;
    of->spring = elastic;
    of->force = plus(normal, sideways);
    of->tangent = minus(of->force, times(dot(of->force, n), n));
    if (fault.dashpot_whole_velocity) of->force = minus(of->force, times(c_n, minus(velocity, times(dot(n, velocity), n))));

    /* Torques: of the force on both, then of rolling and twisting. */
    if (!rotates) return;
    const bool half = half_overlap != (fault.torque_arms == 4);
    const bool whole = fault.torque_arms == 1 || (fault.torque_arms == 2 && flat), short_arm = fault.torque_arms == 3;
    const local less = whole ? 0 : short_arm ? u : (local)0.5 * u;
    const V turns = museum(20) ? plus(times(elastic, n), elastic_sideways) : of->force;
    const V opposite = times(-1, turns), around = cross(n, opposite);
    const bool straight = half || whole || short_arm;
    of->torques[0] = straight ? times(r1 - less, around) : cross(arm1, opposite);
    of->torques[1] = straight ? times(r2 - less, around) : cross(arm2, turns);
    if (museum(113) && !flat) of->torques[1] = of->torques[0];
    for (int at = 0; fault.single == 5 && at < 6; at++) of->torques[at / 3].of[at % 3] = (float)of->torques[at / 3].of[at % 3];
    if (fault.torque_other == 1) of->torques[1] = times(-1, of->torques[1]);
    if (fault.torque_other == 2 || (flat && fault.torque_other == 3)) of->torques[1] = (V){{0}};
    if (fault.cross_sign) of->torques[1].of[AXIS(fault.cross_sign)] *= -1;
    const local pressing = adheres ? fabs(spring + pull) : pressure + pull;
    const bool as_friction = fault.moment_rules == 1;
    if (as_friction && pressing == 0) of->bending = of->twisting = (V){{0}};
    if (!rolling || fault.rolling == 1 || (flat && (fault.rolling == 4 || as_friction))) return;
    if (as_friction && pressing == 0) return;
    const V turning = fault.rolling == 5 ? plus(spin2, spin1) : minus(spin2, spin1);
    V about = times(dot(turning, n), n);
    const V rolls = minus(turning, about);
    if (fault.moment_of_spin == 2) about = times(size(about) / (local)TIME, about);
    V bending = {{0}}, twisting = {{0}};
    if (!old && fault.history_stays == 6 && ended_of(of)) again = *ended_of(of), old = &again;
    if (old && fault.rolling_kept != 2) {
        bending = fault.rolling_kept == 1 ? old->bending : turned(old->bending, old->normal, n, spin1, spin2);
        if (as_friction) bending = cross(n, turned(cross(old->bending, old->normal), old->normal, n, spin1, spin2));
        twisting = fault.twist == 4 ? old->twisting : turned(old->twisting, old->normal, n, spin1, spin2);
    }
    bending = minus(bending, times(bending_stiffness, times(dt, rolls)));
    const local stiff = fault.twist == 2 ? bending_stiffness : twisting_stiffness;
    twisting = minus(twisting, times(fault.twist == 5 ? -stiff : stiff, times(dt, about)));
    local radius = (r1 + r2) / 2;
    if (fault.rolling_radius) radius = fault.rolling_radius == 1 ? k.radius : fault.rolling_radius == 2 ? r1 + r2 : r1;
    if (fault.one_of_two == 4) radius = r2;
    local most = fabs(as_friction ? pressing : fault.rolling_cap == 3 || fault.moment_rules == 2 ? spring : pressure) * (rolling_limit * radius);
    if (fault.moment_of_spin == 1) most *= size(rolls) / (local)TIME;
    if (constant_torque) {
        const local speed = size(fault.moment_rules == 2 ? turning : rolls);
        bending = most > 0 && speed > 0 ? times(-OVER(most, speed), rolls) : (V){{0}};
    }
    const V uncut = bending;
    if (!constant_torque && rolling_limit > 0 && fault.rolling_cap != 1 && pressure != 0 && size(bending) > most)
        bending = times(OVER(most, size(bending)), bending);
    if (rolling_limit > 0 && fault.twist == 3 && size(twisting) > most) twisting = times(OVER(most, size(twisting)), twisting);
    of->bending = fault.rolling_kept == 3 ? uncut : bending;
    if (fault.twist == 6 && flat) twisting = (V){{0}};
    of->twisting = twisting;
    V moment = fault.twist == 1 ? bending : plus(bending, twisting);
    if (rolling_limit > 0 && fault.rolling_cap == 2 && size(moment) > most) moment = times(OVER(most, size(moment)), moment);
    if (fault.rolling == 2) moment = times(-1, moment);
    of->moment = museum(21) ? times(2, moment) : moment;
}

/* ---- sums ---- */

#ifdef PAIRWISE
enum { MOST = 64 };
static struct { int count; local of[6][MOST]; } *collected;

static local total(const local *of, int n)
{
    return n == 0 ? 0 : n == 1 ? *of : total(of, n / 2) + total(of + n / 2, n - n / 2);
}
#endif

static void add(int id, local times, V force, V torque)
{
    Grain *of = &grains[id];
    for (int c = 0; c < 6; c++) {
        local load = c < 3 ? times * force.of[c] : torque.of[c - 3];
        const double left_out = c < 3 ? fault.force_axis : fault.torque_axis;
        if (left_out && c % 3 == AXIS(left_out)) load = 0;
#ifdef PAIRWISE
        if (collected[id].count == MOST) fail("a grain with more than %d contacts", MOST);
        collected[id].of[c][collected[id].count] = load;
#elif defined KAHAN
        const local with = load - of->lost[c], sum = of->load[c] + with;
        of->lost[c] = (sum - of->load[c]) - with;
        of->load[c] = sum;
#else
        of->load[c] += load;
        if (fault.single == 2) of->load[c] = (float)of->load[c];
#endif
    }
#ifdef PAIRWISE
    collected[id].count++;
#endif
    (void)of;
}

static void sum_forces(void)
{
    for (int id = 0; id < count; id++)
        for (int c = 0; c < 6; c++) grains[id].load[c] = grains[id].lost[c] = 0;
#ifdef PAIRWISE
    collected = resized(collected, count, sizeof *collected);
    for (int id = 0; id < count; id++) collected[id].count = 0;
#endif
    punch.force = 0;
    for (size_t at = 0; at < contacts.count; at++) {
#ifdef REVERSED
        Contact *of = &contacts.of[contacts.count - 1 - at];
#else
        Contact *of = &contacts.of[at];
#endif
        const bool pair = of->first < count;
        const bool twice = fault.pairs_twice && pair && (grains[of->first].x[Y] < middle) != (grains[of->second].x[Y] < middle);
        const local times = twice ? 2 : 1;
        if (pair && fault.third_law != 1) add(of->first, -times, of->force, of->torques[0]);
        add(of->second, times, of->force, of->torques[1]);
        if (rolling && pair && fault.rolling != 3) add(of->first, 0, of->moment, minus((V){{0}}, of->moment));
        if (rolling) add(of->second, 0, of->moment, of->moment);
        for (int axis = 0; axis < 3; axis++) of->told.of[axis] = grains[of->second].load[axis];
        if (museum(6)) punch.force += size(of->force);
        else if (of->first == count + wall_count) punch.force -= of->force.of[Z];
    }
#ifdef PAIRWISE
    for (int id = 0; id < count; id++)
        for (int c = 0; c < 6; c++) grains[id].load[c] = total(collected[id].of[c], collected[id].count);
#endif
}

/* ---- the search ---- */

static int by_number(const void *a, const void *b) { return *(const int *)a - *(const int *)b; }

static void list_pair(int id, int other, real margin)
{
    real apart[3];
    for (int axis = 0; axis < 3; axis++) apart[axis] = grains[other].x[axis] - grains[id].x[axis];
    const real reach = margin * (grains[id].radius + grains[other].radius);
    if (other <= id || apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2] > reach * reach) return;
    if (fault.pairs_most == 4 && id >= 128) return;
    if (fault.pairs_most == 3 && other - id > 24) return;
    if (pair_count == pair_room) pairs = resized(pairs, pair_room = 2 * pair_room + 64, sizeof *pairs);
    pairs[pair_count++] = (Pair){other, id}; /* sorted by the other one, then turned round */
}

/* Lists the pairs of grains that are near enough to touch, with cells as wide as the largest grain in a hash table. */
static void search(void)
{
    enum { BUCKETS = 1 << 14 };
    static int first[BUCKETS], *next, (*cell)[3];
    const real margin = adheres == JKR ? 1.05 : fault.pairs_every ? 1 : 1.001; /* rounding must not lose a pair */
    real width = 0;
    for (int id = 0; id < count; id++) width = fmax(width, 2 * margin * grains[id].radius);
#define BUCKET(x, y, z) (((x) * 73856093u ^ (y) * 19349663u ^ (z) * 83492791u) % BUCKETS)
    next = resized(next, count, sizeof *next);
    cell = resized(cell, count, sizeof *cell);
    memset(first, -1, sizeof first);
    for (int id = 0; id < count; id++) {
        for (int axis = 0; axis < 3; axis++) cell[id][axis] = (int)floor(grains[id].x[axis] / width);
        int *bucket = &first[BUCKET((unsigned)cell[id][X], (unsigned)cell[id][Y], (unsigned)cell[id][Z])];
        next[id] = *bucket;
        *bucket = id;
    }
    pair_count = 0;
    for (int id = 0; id < count; id++) {
        const size_t begin = pair_count;
#ifdef ALL_PAIRS
        for (int other = id + 1; other < count; other++) list_pair(id, other, margin);
#else
        for (int near = 0; near < 27; near++) {
            const int x = cell[id][X] + near % 3 - 1, y = cell[id][Y] + near / 3 % 3 - 1, z = cell[id][Z] + near / 9 - 1;
            if (fault.pairs_missed == 1 && y != cell[id][Y]) continue;
            if (fault.pairs_missed == 2 && y < cell[id][Y]) continue;
            if (fault.pairs_missed == 3 && z > cell[id][Z]) continue;
            for (int other = first[BUCKET((unsigned)x, (unsigned)y, (unsigned)z)]; other >= 0; other = next[other])
                if (cell[other][X] == x && cell[other][Y] == y && cell[other][Z] == z) list_pair(id, other, margin);
        }
#endif
        qsort(pairs + begin, pair_count - begin, sizeof *pairs, by_number);
        for (size_t at = begin; at < pair_count; at++) pairs[at] = (Pair){id, pairs[at].first};
        if (fault.pairs_most == 2 && pair_count > begin + 3) pair_count = begin + 3;
    }
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
    while (*old < before.count && in_order(&before.of[*old], &of) < 0) ++*old;
    const Contact *was = *old < before.count && in_order(&before.of[*old], &of) == 0 ? &before.of[*old] : NULL;
    held = was ? was->least : fault.jkr == 2 && adheres == JKR ? -1e-6 / LENGTH : 0;
    if (touches(&of)) act(&of, was);
    else if (was && (fault.history_stays == 1 || fault.history_stays == 6)) {
        gone.of = resized(gone.of, gone.count + 1, sizeof *gone.of);
        gone.of[gone.count++] = *was;
        return;
    }
    else return;
    if (contacts.count == contacts.room)
        contacts.of = resized(contacts.of, contacts.room = 2 * contacts.room + 64, sizeof *contacts.of);
    contacts.of[contacts.count++] = of;
}

static void evaluate_forces(void)
{
    evaluations++;
    const List freed = before;
    before = contacts;
    contacts = (List){freed.of, 0, freed.room};
    if (!fault.pairs_every || searches++ % (int)fault.pairs_every == 0) search();
    if (fault.pairs_most == 1 && pair_count > 150) pair_count = 150;
    static int *partners[3];
    for (int at = 0; at < 3; at++) partners[at] = resized(partners[at], count, sizeof **partners);
    memcpy(partners[2], partners[1], count * sizeof **partners);
    memset(partners[0], 0, count * sizeof **partners), memset(partners[1], 0, count * sizeof **partners);
    for (size_t at = 0; at < before.count; at++)
        if (before.of[at].first < count) partners[1][before.of[at].first]++, partners[1][before.of[at].second]++;
    size_t left = 0;
    for (size_t at = 0; fault.pairs_most == 5 && at < pair_count; at++)
        if (partners[0][pairs[at].second]++ < 3) pairs[left++] = pairs[at];
    if (fault.pairs_most == 5) pair_count = left;
    for (size_t at = 0; fault.history_stays == 5 && evaluations > 2 && at < before.count; at++) {
        const int one = before.of[at].first, two = before.of[at].second;
        if (one < count && (partners[1][one] != partners[2][one] || partners[1][two] != partners[2][two])) before.of[at].shear = (V){{0}};
    }
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
    real *a = of->acceleration, power[6];
    for (int c = 0; c < 6; c++) {
        a[c] = OVER(of->load[c], of->mass[c]) + gravity[c];
        const real judged = of->v[c] + (real)fault.damping_velocity * (dt / 2 * a[c]);
        if (fault.damping_off_gravity) a[c] -= gravity[c];
        power[c] = a[c] * judged;
    }
    if (fault.damping_together) power[0] = power[1] = power[2] = power[0] + power[1] + power[2];
    if (fault.damping_spins == 1) power[3] = power[4] = power[5] = power[3] + power[4] + power[5];
    if (fault.damping_spins == 2) for (int c = 3; c < 6; c++) power[c] = power[c - 3];
    for (int c = 0; c < 6; c++) {
        const bool spared = (c > 2 && fault.damping_off_spin) || (fault.damping_axis && c == AXIS(fault.damping_axis));
        if (!spared) a[c] *= 1 - alpha * (fault.damping_spins == 3 && c > 2 ? (real)0.5 : 1) * ((power[c] > 0) - (power[c] < 0));
        if (fault.damping_off_gravity) a[c] += gravity[c];
    }
}

/* With VERLET velocities are those of whole steps, but for the time between their two halves. */
static void finish_kick(void)
{
#ifdef VERLET
    for (int id = 0; id < count; id++) {
        accelerate(&grains[id]);
        for (int c = 0; c < (rotates ? 6 : 3); c++) grains[id].v[c] += dt / 2 * grains[id].acceleration[c];
    }
#endif
}

/* The forces of the start, made anew with the velocities half a step later. */
static void evaluate_at_whole_step(void)
{
    for (int id = 0; id < count; id++) {
        accelerate(&grains[id]);
        for (int c = 0; c < (rotates ? 6 : 3); c++) grains[id].v[c] += dt / 2 * grains[id].acceleration[c];
    }
    contacts.count = 0;
    evaluate_forces();
    for (int id = 0; id < count; id++)
        for (int c = 0; c < (rotates ? 6 : 3); c++) grains[id].v[c] -= dt / 2 * grains[id].acceleration[c];
}

static void move_punch(void) { punch.x[Z] += punch.velocity * dt; }

static void step_once(void)
{
    steps_made++;
    if (fault.pushed_at && steps_made == fault.pushed_at) grains[0].v[0] += (local)0.1 * TIME / LENGTH;
    if (!fault.punch_late) move_punch();
    const real kick = first_step ? dt * (real)fault.first_kick : dt;
    for (int id = 0; id < count; id++) {
        Grain *of = &grains[id];
        memcpy(of->before, of->x, sizeof of->before);
#ifndef VERLET
        accelerate(of);
#endif
        for (int c = 0; c < (rotates && !fault.spin_blocked ? 6 : 3); c++) {
            if (fault.drift_late && c < 3) of->x[c] += dt * of->v[c];
            if (fault.velocity_axis && c == AXIS(fault.velocity_axis)) continue;
#ifdef VERLET
            of->v[c] += kick / 2 * of->acceleration[c];
#else
            of->v[c] += kick * of->acceleration[c];
#endif
            if (c < 3 && !fault.drift_late) of->x[c] += dt * of->v[c];
            if (c < 3 && museum(114)) of->x[c] += dt * dt / 2 * of->acceleration[c];
        }
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
    return of->v[c] - (rotates || c < 3 ? dt / 2 * of->acceleration[c] : 0);
#else
    if (fault.written_velocity) {
        accelerate(of);
        return of->v[c] + dt / 2 * of->acceleration[c];
    }
    return of->v[c];
#endif
}

static double kinetic_energy(void)
{
    double sum = 0;
    for (int id = 0; id < count; id++)
        for (int c = 0; c < 6; c++) {
            const double v = half_step_velocity(&grains[id], c), m = grains[id].mass[c];
            sum += m * v * v / (museum(19) && c > 2 ? 1 : 2);
        }
    return sum * MASS * LENGTH * LENGTH / (TIME * TIME);
}

/* ---- reading a job ---- */

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

/* The damping ratio of a Hertz contact: without a pull that of Thornton and others (2013, B6). */
static double ratio_of_hertz(double e)
{
    static const double h[] = {-6.918798, -16.41105, 146.8049, -796.4559, 2928.711, -7206.864, 11494.29, -11342.18, 6276.757,
        -1489.915};
    double sum = 0;
    if (fault.restitution_formula == 1) return -log(e) / hypot(acos(-1.0), log(e));
    if (fault.restitution_formula == 2) return -log(e) / acos(-1.0);
    if (fault.restitution_formula == 3) return 1 - e;
    if (!clipped) return sqrt(5.0 / 6) * -log(e) / hypot(acos(-1.0), log(e));
    for (int at = 9; at >= 0; at--) sum = e * (h[at] + sum);
    return sqrt(1 / (1 - (1 + e) * (1 + e) * exp(sum)) - 1);
}

/* Rebound speed over approach speed of a linear spring's dashpot that does not pull (Schwager and Poeschel 2007). */
static double clipped_restitution(double ratio)
{
    const double other = sqrt(fabs(1 - ratio * ratio));
    if (other < 1e-6) return exp(-2.0);
    const double turn = ratio < 1 ? acos(-1.0) - atan2(2 * ratio * other, 1 - 2 * ratio * ratio) : 2 * log(ratio + other);
    return exp(-ratio / other * turn);
}

static double ratio_of_linear(double restitution)
{
    const double logarithm = -log(restitution);
    double low = logarithm / hypot(acos(-1.0), logarithm), high = low;
    if (!clipped || restitution == 1 || museum(5) || museum(26)) return low;
    while (clipped_restitution(high) > restitution) high *= 2;
    for (int halving = 0; halving < 100; halving++) {
        const double half = (low + high) / 2;
        *(clipped_restitution(half) > restitution ? &low : &high) = half;
    }
    return low;
}

static double ratio_of(double e) { return hertz ? ratio_of_hertz(e) / (museum(3) ? sqrt(2.0) : 1) : ratio_of_linear(e); }

static Material material_of(const char *of, Material other)
{
    const double unit = TIME * TIME / MASS * LENGTH;
    other.modulus = number_or(of, "modulus", other.modulus / (fault.modulus * unit)) * fault.modulus * unit;
    other.stiffness_ratio = number_or(of, "stiffness_ratio", other.stiffness_ratio);
    other.poisson = number_or(of, "poissons_ratio", other.poisson / fault.poisson) * fault.poisson;
    other.friction = number_or(of, "friction_angle", other.friction);
    return other;
}

static void read_model(const char *model)
{
    const char *law = member(model, "law"), *contact = member(law, "contact"), *viscosity = member(contact, "viscosity");
    const char *pull = member(model, "gravity"), *list = given(law, "materials"), *one;
    const double down = atof(item(pull, 1)) * fault.gravity * TIME * TIME / LENGTH;
    memset(gravity, 0, sizeof gravity);
    gravity[X] = atof(item(pull, 0)) * TIME * TIME / LENGTH;
    gravity[fault.gravity_axis ? AXIS(fault.gravity_axis) : Z] = down;
    alpha = number(model, "alpha") * fault.alpha;
    dt = number(model, "dt") * fault.dt / TIME;
    materials = resized(materials, 1, sizeof *materials);
    materials[0] = material_of(law, (Material){0});
    friction = materials[0].friction > 0;
    for (int at = 0; list && (one = item(list, at)); at++) {
        materials = resized(materials, at + 2, sizeof *materials);
        materials[at + 1] = material_of(one, materials[0]);
        friction = friction || materials[at + 1].friction > 0;
    }
    wall_friction = number_or(law, "wall_friction_angle", -1);
    punch_friction = number_or(law, "punch_friction_angle", -1);
    friction = friction || wall_friction > 0 || punch_friction > 0;
    rotates = spins && friction && is(contact, "rotation", "free");
    corrected = is(contact, "slip_velocity", "ratcheting_corrected");
    half_overlap = is(contact, "torque_arms", "half_overlap");
    whole_step = is(contact, "new_contact_slip", "whole_step");
    hertz = is(contact, "springs", "hertz_mindlin");
    clipped = is(viscosity, "tension", "clipped");
    damping_constant = number_or(viscosity, "c_n", 0) * fault.c_n * TIME / MASS;
    damping_ratio = is(viscosity, "kind", "restitution") ? ratio_of(number(viscosity, "e_n")) : number_or(viscosity, "ratio", 0);
    shear_ratio = damping_ratio;
    const char *along = given(contact, "tangential_viscosity");
    if (along) shear_ratio = is(viscosity, "kind", "restitution") ? ratio_of(atof(along)) : atof(along);
    dashpots = !is(viscosity, "kind", "none");
    clipped = clipped != (fault.clipping != 0);
    surface_energy = number_or(contact, "adhesion", 0) * fault.adhesion * TIME * TIME / MASS;
    adheres = is(contact, "adhesion_law", "jkr") ? JKR : is(contact, "adhesion_law", "dmt") ? DMT : PULL;
    const char *moments = given(contact, "rolling");
    rolling = moments && rotates;
    if (moments) {
        const double unit = TIME * TIME / (MASS * LENGTH * LENGTH);
        constant_torque = !given(moments, "bending_stiffness");
        bending_stiffness = number_or(moments, "bending_stiffness", 0) * fault.bending * unit;
        twisting_stiffness = number(moments, "twisting_stiffness") * fault.twisting * unit;
        rolling_limit = number_or(moments, "limit", 0) * fault.rolling_limit;
    }
    list = member(model, "walls");
    for (wall_count = 0; (one = item(list, wall_count)); wall_count++) {
        walls = resized(walls, wall_count + 1, sizeof *walls);
        walls[wall_count] = (Wall){is(one, "axis", "x") ? X : is(one, "axis", "y") ? Y : Z, number(one, "place") / LENGTH};
    }
    if (wall_count) walls[wall_count - 1].place -= fault.wall_place * mean_radius;
}

/* The grain with this id in tables. */
static Grain *of_id(int id)
{
#ifdef RENUMBERED
    return &grains[count - 1 - id];
#else
    return &grains[id];
#endif
}

static const char *const NAMES[14] = {"x", "z", "vx", "vz", "spin", "y", "vy", "spin_x", "spin_z", "radius", "mass", "inertia",
    "material", "id"};
static int column[14], columns; /* which of them the table of grains has, in its order */

static void read_grains(char *text)
{
    char *at = text;
    for (columns = 0; *at != '\n'; at += *at == ',') {
        const size_t length = strcspn(at, ",\n");
        int name = 0;
        while (name < 14 && (strlen(NAMES[name]) != length || strncmp(NAMES[name], at, length))) name++;
        if (name == 14 || columns == 14) fail("a column of grains that is unknown: %s", at);
        column[columns++] = name;
        at += length;
    }
    in_space = spins = false;
    for (int c = 0; c < columns; c++) in_space |= column[c] == 5, spins |= column[c] == 4;
    count = 0;
    for (const char *line = ++at; *line; line++) count += *line == '\n';
    grains = resized(grains, count, sizeof *grains);
    if (museum(8)) {
        struct timespec now;
        timespec_get(&now, TIME_UTC);
        srand(now.tv_sec ^ now.tv_nsec);
    }
    mean_radius = middle = 0;
    for (int id = 0; id < count; id++) {
        double row[14] = {0};
        for (int c = 0; c < columns; c++) row[column[c]] = strtod(at, &at), at += *at != 0;
        Grain *of = of_id(id);
        *of = (Grain){.radius = row[9] * fault.radius / LENGTH, .material = fault.material_ignored == 1 ? 0 : row[12]};
        memcpy(of->given, row, sizeof of->given);
        static const int from[9] = {0, 5, 1, 2, 6, 3, 7, 4, 8}; /* places, velocities, spins along x, y, z */
        static const int axes[3] = {X, Y, Z};
        for (int axis = 0; axis < 3; axis++) {
            const int c = axes[axis];
            of->x[c] = of->before[c] = row[from[axis]] / LENGTH;
            of->v[c] = row[from[3 + axis]] * TIME / LENGTH;
            of->v[3 + c] = row[from[6 + axis]] * TIME;
            of->mass[c] = row[10] * fault.mass * (fault.mass_of_disc ? 1.5 : 1) / MASS;
            const double disc = fault.inertia_of_disc == 1 || (fault.inertia_of_disc == 2 && c == Y) ? 1.25 : 1;
            of->mass[3 + c] = spins ? row[11] * fault.inertia * disc / (MASS * LENGTH * LENGTH) : 1;
        }
        if (museum(8)) of->x[X] = of->before[X] += of->radius * 1e-3 * ((double)rand() / RAND_MAX - 0.5);
        mean_radius += of->radius / count;
        middle += of->x[Y] / count;
    }
    free(text);
}

static void read_punch(const char *of)
{
    punch.there = of && *of == '{';
    if (!punch.there) return;
    punch.start = number(of, "start");
    punch.velocity = number(of, "velocity") * fault.punch_speed * TIME / LENGTH;
    for (int axis = 0; axis < 2; axis++) {
        punch.x[axis ? Z : X] = atof(item(member(of, "centre"), axis)) / LENGTH;
        punch.half[axis ? Z : X] = atof(item(member(of, "half_extents"), axis)) / LENGTH;
    }
}

/* ---- writing ---- */

static const char *folder_of_tables;
static FILE *lines;
#ifndef TABLES
static FILE *tables;
#endif

static double written(Grain *of, int column, bool as_given)
{
    if (as_given || column > 8) return of->given[column];
    static const int component[9] = {0, 2, 0, 2, 1, 1, 1, 0, 2};
    static const int axes[3] = {X, Y, Z};
    if (fault.table_spins && column > 6) column = 15 - column;
    const int c = axes[component[column]];
    if (column == 5 && fault.table_velocity) return of->before[c] * LENGTH;
    if (column < 2 || column == 5) return of->x[c] * LENGTH;
    if (column < 4 || column == 6) return half_step_velocity(of, c) * LENGTH / TIME;
    return half_step_velocity(of, 3 + c) / TIME;
}

typedef struct { double of[14]; } Row; /* id1 id2 overlap fn ft nx nz x z ny y ftx fty ftz */

static int by_ids(const void *a, const void *b)
{
    const double *one = ((const Row *)a)->of, *two = ((const Row *)b)->of;
    return one[0] != two[0] ? (one[0] > two[0] ? 1 : -1) : (one[1] > two[1]) - (one[1] < two[1]);
}

static Row row_of(const Contact *of)
{
    const bool wall = of->first >= count && of->first < count + wall_count;
    V n = of->normal, point = of->point, t = of->tangent;
    if (museum(18)) t = minus(of->told, times(dot(of->told, n), n));
    int first = of->first, second = of->second;
#ifdef RENUMBERED
    second = count - 1 - second;
    if (first < count) {
        const int other = second;
        second = count - 1 - first;
        first = other;
        n = times(-1, n);
        t = times(-1, t);
    }
#endif
    if (fault.table_point) point.of[AXIS(fault.table_point)] *= -1;
    if (fault.table_normal) n.of[AXIS(fault.table_normal)] *= -1;
    if (fault.table_tangent) t.of[AXIS(fault.table_tangent)] *= -1;
    if (fault.table_first) t = times(-1, t);
    if (wall && fault.table_wall_point) point = plus(point, times(of->overlap / 2, n));
    if (fault.table_order == 2 && first < count) {
        const int other = second;
        second = first, first = other;
    }
    if (fault.table_order == 3 && wall && walls[of->first - count].axis == Y) first = 2 * count + 7 - first;
    const double newton = MASS * LENGTH / (TIME * TIME), across = t.of[Z] * n.of[X] - t.of[X] * n.of[Z];
    const double ft = in_space && !fault.table_tangent_size ? size(t) : across;
    const double fn = fault.table_spring ? of->spring : dot(museum(18) ? of->told : of->force, of->normal);
    const double overlap = of->overlap * LENGTH * (fault.table_overlap ? 0.5 : 1);
    return (Row){{first, second, overlap, fn * newton, ft * newton, n.of[X], n.of[Z], point.of[X] * LENGTH, point.of[Z] * LENGTH,
        n.of[Y], point.of[Y] * LENGTH, t.of[X] * newton, t.of[Y] * newton, t.of[Z] * newton}};
}

/* Sorted by ids; how many. */
static size_t rows_of_contacts(Row **rows)
{
    static Row *of;
    size_t most = contacts.count, kept = 0;
    of = resized(of, most, sizeof *of);
    for (size_t at = 0; at < most; at++) {
        const Contact *from = &contacts.of[at];
        if (fault.table_missing == 1 && from->first >= count + 3) continue;
        if (fault.table_missing == 2 && at == most - 1) continue;
        of[kept] = row_of(from);
        if (fault.table_missing != 3 || of[kept].of[3] > 0) kept++;
    }
    qsort(of, kept, sizeof *of, by_ids);
    for (size_t at = 0; fault.table_order == 1 && at < kept / 2; at++) {
        const Row other = of[at];
        of[at] = of[kept - 1 - at], of[kept - 1 - at] = other;
    }
    *rows = of;
    return kept;
}

static void write_moment(const char *stage, long step, bool as_given)
{
    Row *rows;
    if (museum(17) && !as_given) evaluate_forces();
    const size_t kept = rows_of_contacts(&rows);
    const int wide = in_space ? 14 : 9;
#ifdef TABLES
    static const char *const headers[2] = {"id1,id2,overlap,fn,ft,nx,nz,x,z", ",ny,y,ftx,fty,ftz"};
    char name[64];
    snprintf(name, sizeof name, "%s-%ld-bodies.csv", stage, step);
    FILE *file = opened(folder_of_tables, name, "w");
    for (int c = 0; c < columns; c++) fprintf(file, c ? ",%s" : "%s", NAMES[column[c]]);
    for (int id = 0; id < count; id++)
        for (int c = 0; c < columns; c++)
            fprintf(file, c ? ",%.17g" : "\n%.17g", written(of_id(id), column[c], as_given));
    fputc('\n', file);
    fclose(file);
    snprintf(name, sizeof name, "%s-%ld-contacts.csv", stage, step);
    file = opened(folder_of_tables, name, "w");
    fprintf(file, "%s%s\n", headers[0], in_space ? headers[1] : "");
    for (size_t at = 0; at < kept; at++)
        for (int c = 0; c < wide; c++) fprintf(file, "%.17g%c", rows[at].of[c], c < wide - 1 ? ',' : '\n');
    fclose(file);
    fprintf(lines, "{\"stage\": \"%s\", \"step\": %ld, \"punch\": ", stage, step);
#else
    for (int c = 0; c < 9; c++)
        for (int id = 0; id < count && (c < 4 || (c != 5 && c != 6 ? spins : in_space)) && (c < 5 || in_space); id++) {
            const double value = written(of_id(id), c, as_given);
            fwrite(&value, sizeof value, 1, tables);
        }
    for (size_t at = 0; at < kept; at++) fwrite(rows[at].of, sizeof(double), wide, tables);
    fprintf(lines, "{\"stage\": \"%s\", \"step\": %ld, \"contacts\": %zu, \"punch\": ", stage, step, kept);
#endif
    if (punch.there)
        fprintf(lines, "{\"centre\": [%.17g, %.17g], \"start\": %.17g, \"velocity\": %.17g, \"force\": %.17g}}\n",
            (double)punch.x[X] * LENGTH, (double)punch.x[Z] * LENGTH, punch.start, (double)punch.velocity * LENGTH / TIME,
            punch.force * MASS * LENGTH / (TIME * TIME));
    else fprintf(lines, "null}\n");
}

/* ---- jobs ---- */

/* A punch on the highest grain below it. */
static void lower_punch(const char *loading)
{
    const double axis = number(loading, "axis");
    double top = 0;
    for (int at = 0; at < 2; at++) punch.half[at ? Z : X] = atof(item(member(loading, "half_extents"), at)) / LENGTH;
    for (int id = 0; id < count; id++)
        if (fabs(grains[id].x[X] - axis / LENGTH) < punch.half[X] + grains[id].radius)
            top = fmax(top, (double)(grains[id].x[Z] + grains[id].radius));
    punch.there = true;
    punch.x[X] = axis / LENGTH;
    punch.x[Z] = top + punch.half[Z];
    punch.start = top * LENGTH;
    punch.velocity = -number(loading, "speed") * fault.punch_speed * TIME / LENGTH;
}

static void end_stage(const char *stage, long steps, const char *stop)
{
    const double seconds = (double)clock() / CLOCKS_PER_SEC;
    fprintf(lines, "{\"end\": \"%s\", \"steps\": %ld, \"stop\": \"%s\", \"wall_seconds\": %g, \"cpu_seconds\": %g}\n",
        stage, steps, stop, seconds, seconds);
}

static long run_case(const char *job)
{
    const char *moment = item(member(job, "moments"), 0);
    long steps = 0;
    for (long step = 0; moment && *moment != ']'; step++) {
        if (step) step_once(), steps++;
        if (step != atol(moment)) continue;
        write_moment("settle", step, step == 0);
        moment = space(behind(moment));
    }
    return steps;
}

/* From its first step to until, or to the end by its rule; how it ended. */
static const char *run_stage(const char *job, const char *stage, long start, long until, bool as_given, long *step)
{
    const bool load = !strcmp(stage, "load");
    const long every = number(job, "moments_every");
    const char *settle = load ? NULL : member(job, "settle"), *loading = load ? member(job, "loading") : NULL;
    const double still = load ? number_or(loading, "steps_standing_still", -1) : -1;
    double seen = load ? 0 : number(job, "energy_seen");
    long last = -1;
    const char *stop = NULL;
    for (*step = start; !stop; ++*step) {
        if (*step > start) step_once();
        if (until >= 0) stop = *step == until ? "steps_done" : NULL;
        else if (!load && *step > start) {
            if (*step % (long)number(settle, "check_every") == 0) {
                const double energy = kinetic_energy();
                seen = fmax(seen, energy);
                if (energy <= number(settle, "kinetic_energy_fraction") * seen) stop = "settled";
            }
            if (!stop && *step >= number(settle, "max_steps")) stop = "max_steps";
        } else if (load && *step > start) {
            const double depth = punch.start - (punch.x[Z] - punch.half[Z]) * LENGTH;
            if (last < 0 && punch.force * MASS * LENGTH / (TIME * TIME) >= number(loading, "target_force")) {
                last = *step + (still > 0 ? (long)still : 0);
                punch.velocity = still >= 0 ? 0 : punch.velocity;
            }
            if (last == *step) stop = "reached";
            else if (last < 0 && depth >= number(loading, "give_up_depth")) stop = "target_load_not_reached";
        }
        if (stop || *step == start || *step % every == 0) write_moment(stage, *step, as_given && *step == start);
    }
    end_stage(stage, --*step, stop);
    return stop;
}

static long run_scene(const char *job)
{
    const char *stage = is(job, "stage", "load") ? "load" : "settle", *loading_model = given(job, "loading_model");
    const long start = number(job, "step"), until = number_or(job, "until_step", -1);
    const bool ends_settled = !strncmp(member(job, "ends_settled"), "true", 4);
    long step, steps = 0;
    bool as_given = true;
    if (!strcmp(stage, "settle")) {
        const char *stop = run_stage(job, stage, start, until, true, &step);
        steps = step - start;
        if (ends_settled || strcmp(stop, "settled")) return steps;
        as_given = false;
    }
    /* The punch that is lowered now bears no force yet. */
    const long first = strcmp(stage, "load") ? 0 : start;
    if (!punch.there) lower_punch(member(job, "loading"));
    if (loading_model) read_model(loading_model);
    run_stage(job, "load", first, until, as_given, &step);
    return steps + step - first;
}

/* Does a job; the steps that were done. */
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
        free(job);
        return steps;
    }
    read_grains(read_all(folder, "initial.csv"));
    read_model(member(job, "model"));
    read_punch(given(job, "punch"));
    folder_of_tables = folder;
    lines = opened(folder, "moments.jsonl", "w");
    if (fault.plane_refused && !in_space) {
        fprintf(lines, "{\"refused\": \"no plane here\"}\n");
        fclose(lines);
        free(job);
        return 0;
    }
#ifndef TABLES
    tables = opened(folder, "tables.bin", "wb");
#endif
    contacts.count = gone.count = searches = evaluations = 0;
    first_step = true;
    evaluate_forces();
    if (museum(16)) evaluate_at_whole_step();
    finish_kick();
    steps = is(job, "kind", "scene") ? run_scene(job) : run_case(job);
    fclose(lines);
#ifndef TABLES
    fclose(tables);
#endif
    free(job);
    return steps;
}

/* The velocities of VERLET at whole steps are not those of half steps where another law takes over. */
#ifdef VERLET
#define STAGES ""
#else
#define STAGES "\"stages\", "
#endif

static void describe(void)
{
    static const char *const of_space[3] = {"\"space\", \"hertz_mindlin\", \"moments\", \"constant_moments\", \"adhesion\", \"dmt\", \"jkr\", \"materials\", ",
        "",
        "\"space_alone\", \"hertz_mindlin\", \"moments\", \"constant_moments\", \"adhesion\", \"dmt\", \"jkr\", \"materials\", "};
    const char *rules = "";
    if (museum(14)) rules = ", \"rules\": {\"given_velocities\": \"at_start\", \"written_velocities\": \"whole_step\"}";
    static const char *const kept[8] = {"", "\"spring_memory\": \"displacement\"", "\"spring_memory\": \"displacement_rescaled\"",
        "\"spring_memory\": \"force_rescaled\"", "\"wall_radius\": \"flat\"",
        "\"wall_radius\": \"flat\", \"spring_memory\": \"displacement\"",
        "\"moment_turn\": \"as_force\", \"moment_limit\": \"as_friction\", \"moments_at_walls\": \"none\"",
        "\"moment_limit\": \"spring\", \"constant_moment\": \"share_of_spin\""};
    char declared[128];
    snprintf(declared, sizeof declared, ", \"rules\": {%s}", kept[(int)fault.declares]);
    if (fault.declares) rules = declared;
    if (museum(26)) rules = ", \"rules\": {\"restitution\": \"cut\"}";
    printf("{\"protocol\": %d, \"name\": \"spheres\", \"version\": \"1\", \"parts\": [\"normal_spring\", \"tangential_spring\", "
           "\"wall_friction\", \"rotation\", \"dashpots\", \"local_damping\", " STAGES "%s\"gravity\", \"walls\", \"punch\", "
           "\"stop_rules\", \"cases\"]%s}\n", *rules ? 2 : 1, of_space[(int)fault.parts], rules);
}

int main(int words, char **word)
{
    const char *name = strrchr(word[0], '/'), *behind_dashes = strstr(name ? name : word[0], "--");
    read_faults(getenv("FAULT"));
    if (behind_dashes) read_faults(behind_dashes + 2);
    if (words == 2 && !strcmp(word[1], "describe")) {
        describe();
        return 0;
    }
    if (words != 3 || strcmp(word[1], "run")) fail("usage: spheres describe | spheres run FOLDER");
    const long steps = run(word[2]);
    FILE *done = opened(word[2], "done.json", "w");
    fprintf(done, "{\"steps\": %ld}\n", steps);
    return fclose(done);
}
