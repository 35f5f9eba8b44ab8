/* Declarations for other files:
 *
 *   void @PREFIX@_inverse_dynamics(const double *q, const double *qd, const double *qdd, double *tau);
 *   void @PREFIX@_gravity(const double *q, double *tau);
 *   void @PREFIX@_mass_matrix(const double *q, double *m);   N x N, row by row
@DECLARATIONS@@CHANNEL_DECLARATIONS@ */
#include <math.h>
#include <string.h>

@TABLES@
@CHANNEL_HELPER@static double sign(double x) { return (double)((x > 0.0) - (x < 0.0)); }

static double clamp(double x) { return x > 1.0 ? 1.0 : (x < -1.0 ? -1.0 : x); }

static void cross(const double a[3], const double b[3], double c[3])
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* c = A b for A row by row, and its transpose times b */
static void times(const double *a, const double b[3], double c[3])
{
    for (int i = 0; i < 3; i++) c[i] = a[3 * i] * b[0] + a[3 * i + 1] * b[1] + a[3 * i + 2] * b[2];
}

static void transposed_times(const double *a, const double b[3], double c[3])
{
    for (int i = 0; i < 3; i++) c[i] = a[i] * b[0] + a[3 + i] * b[1] + a[6 + i] * b[2];
}

/* Torques of the bodies by recursive Newton-Euler (Luh, Walker, Paul 1980). */
static void rigid_body(const double *q, const double *qd, const double *qdd, const double *gravity, double *tau)
{
    double rotation[N][3][3], shift[N][3], force[N][3], moment[N][3];
    double w[3] = {0, 0, 0}, dw[3] = {0, 0, 0}, a[3] = {-gravity[0], -gravity[1], -gravity[2]};
    for (int k = 0; k < N; k++) {
        double s = REVOLUTE[k] ? sin(q[k]) : 0.0, c = REVOLUTE[k] ? cos(q[k]) : 1.0;
        double slide = REVOLUTE[k] ? 0.0 : q[k];
        for (int i = 0; i < 3; i++) {
            double x = ROTATION[k][i][0], y = ROTATION[k][i][1], z = ROTATION[k][i][2];
            rotation[k][i][0] = c * x + s * y;
            rotation[k][i][1] = c * y - s * x;
            rotation[k][i][2] = z;
            shift[k][i] = TRANSLATION[k][i] + slide * z;
        }
        double t1[3], t2[3], t3[3], sum[3];
        cross(dw, shift[k], t1);
        cross(w, shift[k], t2);
        cross(w, t2, t3);
        for (int i = 0; i < 3; i++) sum[i] = a[i] + t1[i] + t3[i];
        double w0[3], dw0[3];
        transposed_times(&rotation[k][0][0], sum, a);
        transposed_times(&rotation[k][0][0], w, w0);
        transposed_times(&rotation[k][0][0], dw, dw0);
        memcpy(w, w0, sizeof w);
        memcpy(dw, dw0, sizeof dw);
        if (REVOLUTE[k]) {
            dw[0] += w[1] * qd[k];
            dw[1] -= w[0] * qd[k];
            dw[2] += qdd[k];
            w[2] += qd[k];
        } else {
            a[0] += 2.0 * w[1] * qd[k];
            a[1] -= 2.0 * w[0] * qd[k];
            a[2] += qdd[k];
        }
        double iw[3], idw[3];
        cross(dw, MOMENT[k], t1);
        cross(w, MOMENT[k], t2);
        cross(w, t2, t3);
        for (int i = 0; i < 3; i++) force[k][i] = MASS[k] * a[i] + t1[i] + t3[i];
        times(&INERTIA[k][0][0], dw, idw);
        times(&INERTIA[k][0][0], w, iw);
        cross(w, iw, t1);
        cross(MOMENT[k], a, t2);
        for (int i = 0; i < 3; i++) moment[k][i] = idw[i] + t1[i] + t2[i];
    }
    for (int k = N - 1; k >= 0; k--) {
        tau[k] = REVOLUTE[k] ? moment[k][2] : force[k][2];
        if (k == 0) break;
        double f[3], m[3], lever[3];
        times(&rotation[k][0][0], force[k], f);
        times(&rotation[k][0][0], moment[k], m);
        cross(shift[k], f, lever);
        for (int i = 0; i < 3; i++) {
            force[k - 1][i] += f[i];
            moment[k - 1][i] += m[i] + lever[i];
        }
    }
}

/* Torque of the joints beside that of the bodies, for the true position, velocity and acceleration of the motors. */
static void torques(const double *q, const double *qd, const double *qdd, const double *rigid,@CHANNELS@ double *tau)
{
    double declared[N];
    for (int k = 0; k < N; k++) declared[k] = rigid[k] + VISCOUS[k] * qd[k] + COULOMB[k] * sign(qd[k]);
    memcpy(tau, declared, sizeof declared);
@EFFECTS@    for (int k = 0; k < N; k++) tau[k] *= GAIN[k];
@UNUSED@    (void)clamp;
    (void)q;
    (void)qdd;
}

void @PREFIX@_inverse_dynamics@AT@(const double *position, const double *qd, const double *qdd,@CHANNELS@ double *tau)
{
    double q[N], rigid[N];
    for (int k = 0; k < N; k++) q[k] = position[k] + OFFSET[k];
    rigid_body(q, qd, qdd, GRAVITY, rigid);
    torques(q, qd, qdd, rigid,@PASS@ tau);
}

void @PREFIX@_gravity@AT@(const double *position,@CHANNELS@ double *tau)
{
    static const double still[N] = {0};
    @PREFIX@_inverse_dynamics@AT@(position, still, still,@PASS@ tau);
}

void @PREFIX@_mass_matrix@AT@(const double *position,@CHANNELS@ double *out)
{
    static const double still[N] = {0}, none[3] = {0};
    double q[N], r[N][N], m[N][N];
    for (int k = 0; k < N; k++) q[k] = position[k] + OFFSET[k];
    for (int c = 0; c < N; c++) {
        double unit[N] = {0}, column[N];
        unit[c] = 1.0;
        rigid_body(q, still, unit, none, column);
        for (int k = 0; k < N; k++) r[k][c] = column[k];
    }
    memcpy(m, r, sizeof m);
@UNUSED@@MASS@    for (int k = 0; k < N; k++)
        for (int c = 0; c < N; c++) out[k * N + c] = GAIN[k] * m[k][c];
}
@OVERLOADS@@MEMORY_PART@@MEMORY_OVERLOADS@