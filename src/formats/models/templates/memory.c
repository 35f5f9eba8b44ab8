
/* Effects with memory: they depend on the samples before the present one, and inverse_dynamics leaves them out. */

#include <stdlib.h>

/* Highest sample rate that step takes; the size of its state grows with it. */
#ifndef FASTEST_HZ
#define FASTEST_HZ 1000
#endif

@MEMORY@
/* Half the window (us) over which the load of an elastic joint is differentiated, and the fewest samples to both sides. */
enum {
    REACH_US = @REACH_US@,
    FEWEST = @FEWEST@,
    BACK = 2 * (REACH_US * FASTEST_HZ / 1000000 + 1 + FEWEST) + 1,
    LATE = DELAY_US * FASTEST_HZ / 1000000 + 3
};

typedef struct {
    double q[N], qd[N], qdd[N];
} sample;

/* Position, velocity and acceleration between two samples that are h apart, at the part u: the quintic through both. */
static void between(const sample *a, const sample *b, double u, double h, sample *out)
{
    for (int j = 0; j < N; j++) {
        double q0 = a->q[j], v0 = a->qd[j] * h, a0 = a->qdd[j] * h * h, v1 = b->qd[j] * h, a1 = b->qdd[j] * h * h;
        double d = b->q[j] - q0 - v0 - 0.5 * a0, e = v1 - v0 - a0, f = a1 - a0;
        double c3 = 10.0 * d - 4.0 * e + 0.5 * f, c4 = -15.0 * d + 7.0 * e - f, c5 = 6.0 * d - 3.0 * e + 0.5 * f;
        out->q[j] = q0 + u * (v0 + u * (0.5 * a0 + u * (c3 + u * (c4 + u * c5))));
        out->qd[j] = (v0 + u * (a0 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) / h;
        out->qdd[j] = (a0 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))) / (h * h);
    }
}

/* Constant acceleration from a sample on. */
static void onward(const sample *a, double t, sample *out)
{
    for (int j = 0; j < N; j++) {
        out->q[j] = a->q[j] + a->qd[j] * t + 0.5 * a->qdd[j] * t * t;
        out->qd[j] = a->qd[j] + a->qdd[j] * t;
        out->qdd[j] = a->qdd[j];
    }
}

/* Dahl 1968: the state of presliding friction over a step; exact where the joint does not turn back within it, else in two parts. */
static double slide(double z, double distance, double width)
{
    double s = sign(distance);
    return distance == 0.0 ? z : s + (z - s) * exp(-fabs(distance) / width);
}

static double presliding(double z, const sample *a, const sample *b, int j, double h, double width)
{
    double v0 = a->qd[j], v1 = b->qd[j];
    if (v0 * v1 >= 0.0) return slide(z, b->q[j] - a->q[j], width);
    double acceleration = (v1 - v0) / h;
    return slide(slide(z, -0.5 * v0 * v0 / acceleration, width), 0.5 * v1 * v1 / acceleration, width);
}

static int reach_at(double sample_time)
{
    int reach = (int)floor(1e-6 * REACH_US / sample_time + 0.5);
    return reach < FEWEST ? FEWEST : reach;
}

/* Local cubic over 2 reach + 1 values (Savitzky-Golay): first and second derivative by the number of the value, at offset k from the middle. */
static void cubic(const double *values, int reach, double k, double *first, double *second)
{
    double m = 2.0 * reach + 1.0, s2 = 0, s4 = 0, s6 = 0, x0 = 0, x1 = 0, x2 = 0, x3 = 0;
    for (int i = -reach; i <= reach; i++) {
        double v = values[i + reach], p = (double)i * i;
        s2 += p;
        s4 += p * p;
        s6 += p * p * p;
        x0 += v;
        x1 += i * v;
        x2 += p * v;
        x3 += i * p * v;
    }
    double odd = s2 * s6 - s4 * s4, even = m * s4 - s2 * s2;
    double c1 = (s6 * x1 - s4 * x3) / odd, c2 = (m * x2 - s2 * x0) / even, c3 = (s2 * x3 - s4 * x1) / odd;
    *first = c1 + 2.0 * c2 * k + 3.0 * c3 * k * k;
    *second = 2.0 * c2 + 6.0 * c3 * k;
}

static void loads(const sample *at, const double *gravity, int with_offset, double *load)
{
    double q[N];
    for (int k = 0; k < N; k++) q[k] = at->q[k] + (with_offset ? OFFSET[k] : 0.0);
    rigid_body(q, at->qd, at->qdd, gravity, load);
}

/* Bodies move with the links, friction with the motors. */
static void torque_at(const sample *at, const sample *link, const double *z,@CHANNELS@ double *tau)
{
    double q[N], load[N];
    for (int k = 0; k < N; k++) q[k] = at->q[k] + OFFSET[k];
    loads(link, GRAVITY, 1, load);
    torques(q, at->qd, at->qdd, load,@PASS@ tau);
    for (int i = 0; i < HYSTERESES; i++) {
        int j = HYSTERESIS[i].joint;
        tau[j] += GAIN[j] * HYSTERESIS[i].level * (z[i] - sign(at->qd[j]));
    }
}

/* Motion of the motors, then of the links: a late torque belongs to an earlier sample, elastic joints give way under their loads. */
static void distort(long count, double h, const sample *in, const double *load, sample *spare, double *window, sample *motors, sample *links)
{
    int reach = reach_at(h), bends = 0;
    sample *out = motors;
    memcpy(motors, in, (size_t)count * sizeof *in);
    for (int d = 0; d < DISTORTIONS; d++) {
        int j = DISTORTION[d].joint;
        if (j >= 0 && !bends) {
            memcpy(links, motors, (size_t)count * sizeof *in);
            out = links;
            bends = 1;
        }
        double value = DISTORTION[d].value;
        if (j < 0) memcpy(spare, out, (size_t)count * sizeof *out);
        for (long s = 0; s < count; s++) {
            if (j < 0) {
                double at = (double)s - value / h, last = (double)(count - 1);
                long first = (long)floor(at);
                if (at < 0.0 || at > last)
                    onward(&spare[at < 0.0 ? 0 : count - 1], (at - (at < 0.0 ? 0.0 : last)) * h, &out[s]);
                else if (at == (double)first)
                    out[s] = spare[first];
                else
                    between(&spare[first], &spare[first + 1], at - (double)first, h, &out[s]);
                continue;
            }
            for (int k = -reach; k <= reach; k++) {
                long i = s + k < 0 ? 0 : (s + k >= count ? count - 1 : s + k);
                window[k + reach] = load[i * N + j];
            }
            double first, second;
            cubic(window, reach, 0.0, &first, &second);
            out[s].q[j] -= value * load[s * N + j];
            out[s].qd[j] -= value * first / h;
            out[s].qdd[j] -= value * second / (h * h);
        }
    }
    if (!bends) memcpy(links, motors, (size_t)count * sizeof *in);
}

/* Torques along a whole motion that is known: count samples, sample_time (s) apart, rows of N values. 0 if done, 1 where there is no memory for it or
 * the arguments make no motion. */
int @PREFIX@_predict@AT@(long count, double sample_time, const double *q, const double *qd, const double *qdd,@CHANNELS@ double *tau)
{
    if (count < 1 || !(sample_time > 0.0)) return 1;
    size_t size = (size_t)count;
    sample *in = malloc(size * sizeof *in), *out = malloc(size * sizeof *out), *links = malloc(size * sizeof *links), *spare = malloc(size * sizeof *spare);
    double *load = malloc(size * N * sizeof *load), *window = malloc((2 * (size_t)reach_at(sample_time) + 1) * sizeof *window);
    int failed = !in || !out || !links || !spare || !load || !window;
    double z[HYSTERESES + 1] = {0};
    if (!failed) {
        for (long s = 0; s < count; s++) {
            memcpy(in[s].q, q + s * N, sizeof in[s].q);
            memcpy(in[s].qd, qd + s * N, sizeof in[s].qd);
            memcpy(in[s].qdd, qdd + s * N, sizeof in[s].qdd);
            loads(&in[s], LEVEL_GRAVITY, 0, load + s * N);
        }
        distort(count, sample_time, in, load, spare, window, out, links);
        for (int round = 0; round < LOAD_ROUNDS; round++) {
            for (long s = 0; s < count; s++) loads(&links[s], GRAVITY, 1, load + s * N);
            distort(count, sample_time, in, load, spare, window, out, links);
        }
        for (int i = 0; i < HYSTERESES; i++)
            for (long s = 0; s < count && z[i] == 0.0; s++) z[i] = sign(out[s].qd[HYSTERESIS[i].joint]);
        for (long s = 0; s < count; s++) {
            for (int i = 0; i < HYSTERESES && s > 0; i++)
                z[i] = presliding(z[i], &out[s - 1], &out[s], HYSTERESIS[i].joint, sample_time, HYSTERESIS[i].width);
            torque_at(&out[s], &links[s], z,@PASS_ROW@ tau + s * N);
        }
    }
    free(in);
    free(out);
    free(links);
    free(spare);
    free(load);
    free(window);
    return failed;
}

/* What step keeps from sample to sample; cleared by reset, read and written by step alone. */
struct @PREFIX@_state {
    double sample_time;
    long count;
    int started[HYSTERESES + 1];
    double z[HYSTERESES + 1];
    double load[LOAD_ROUNDS + 1][ELASTIC + 1][BACK];
    sample before, late[LATE];
};

size_t @PREFIX@_state_size(void) { return sizeof(struct @PREFIX@_state); }

/* Before the first sample. 0 if done, 1 where the samples are closer than FASTEST_HZ allows. */
int @PREFIX@_reset(struct @PREFIX@_state *state, double sample_time)
{
    memset(state, 0, sizeof *state);
    state->sample_time = sample_time;
    return !(sample_time * FASTEST_HZ >= 1.0 - 1e-9);
}

/* The load of an elastic joint joins those before it; its derivatives come from the samples up to now. */
static void bend(struct @PREFIX@_state *state, double *back, double load, double compliance, int j, sample *out)
{
    int reach = (reach_at(state->sample_time) + 1) / 2, all = 2 * reach + 1;
    for (int i = 0; i < all; i++) back[i] = state->count == 0 ? load : (i + 1 < all ? back[i + 1] : load);
    double first, second, h = state->sample_time;
    cubic(back, reach, reach, &first, &second);
    out->q[j] -= compliance * load;
    out->qd[j] -= compliance * first / h;
    out->qdd[j] -= compliance * second / (h * h);
}

/* Torque for the next sample: the same as predict gives, but for elastic joints, whose loads are differentiated looking back only. */
void @PREFIX@_step@AT@(struct @PREFIX@_state *state, const double *q, const double *qd, const double *qdd,@CHANNELS@ double *tau)
{
    sample now, link;
    double load[N], delay = 0.0;
    /* late[0] is the present sample. The delay comes first: samples as they are given belong together, bent ones do not. */
    long kept = state->count < LATE - 1 ? state->count : LATE - 1;
    memmove(state->late + 1, state->late, (size_t)kept * sizeof(sample));
    memcpy(state->late[0].q, q, sizeof now.q);
    memcpy(state->late[0].qd, qd, sizeof now.qd);
    memcpy(state->late[0].qdd, qdd, sizeof now.qdd);
    for (int d = 0; d < DISTORTIONS; d++)
        if (DISTORTION[d].joint < 0) delay += DISTORTION[d].value;
    double ago = delay / state->sample_time, oldest = (double)kept;
    long whole = (long)ceil(ago);
    if (ago < 0.0 || ago > oldest)
        onward(&state->late[ago < 0.0 ? 0 : (long)oldest], ((ago < 0.0 ? 0.0 : oldest) - ago) * state->sample_time, &now);
    else if (ago == (double)whole)
        now = state->late[whole];
    else
        between(&state->late[whole], &state->late[whole - 1], (double)whole - ago, state->sample_time, &now);
    link = now;
    for (int round = 0; round <= LOAD_ROUNDS; round++) {
        loads(&link, round ? GRAVITY : LEVEL_GRAVITY, round, load);
        link = now;
        for (int d = 0, e = 0; d < DISTORTIONS; d++)
            if (DISTORTION[d].joint >= 0)
                bend(state, state->load[round][e++], load[DISTORTION[d].joint], DISTORTION[d].value, DISTORTION[d].joint, &link);
    }
    for (int i = 0; i < HYSTERESES; i++) {
        int j = HYSTERESIS[i].joint;
        if (!state->started[i]) state->z[i] = sign(now.qd[j]);
        else state->z[i] = presliding(state->z[i], &state->before, &now, j, state->sample_time, HYSTERESIS[i].width);
        state->started[i] = state->started[i] || state->z[i] != 0.0;
    }
    torque_at(&now, &link, state->z,@PASS@ tau);
    state->before = now;
    state->count++;
}
