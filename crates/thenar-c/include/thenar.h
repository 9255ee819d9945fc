/* Thenar for C. Made by cbindgen from crates/thenar-c/src: do not edit. docs/c.md tells how it is used. */

#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Compare with thenar_abi_version(): another number means that programs must be built again. */
#define THENAR_ABI_VERSION 1

/*
 Outcome of a call.
 */
typedef enum ThenarStatus {
  /*
   The call did what was asked.
   */
  THENAR_STATUS_OK = 0,
  /*
   A pointer is null or not aligned, a size does not fit, text is not UTF-8, or there is no
   such body or hand.
   */
  THENAR_STATUS_ARGUMENT = 1,
  /*
   The scene is wrong, or there is none.
   */
  THENAR_STATUS_SCENE = 2,
  /*
   A hand cannot follow what was given.
   */
  THENAR_STATUS_POSE = 3,
  /*
   The setting does not exist, or the value is out of its range.
   */
  THENAR_STATUS_SETTING = 4,
  /*
   The bytes are no state of this world.
   */
  THENAR_STATUS_STATE = 5,
  /*
   Another thread has the world.
   */
  THENAR_STATUS_BUSY = 6,
  /*
   The world has failed for good: free it, and make another from its scene.
   */
  THENAR_STATUS_BROKEN = 7,
} ThenarStatus;

/*
 A running scene. Its inside is nobody's but its functions'.
 */
typedef struct ThenarWorld ThenarWorld;

/*
 A contact point of the last step, near or touching.
 */
typedef struct ThenarContact {
  /*
   Bodies A and B: places in the rigid bodies, then the deformable ones.
   */
  int32_t bodies[2];
  /*
   The vertex of each one's surface that is nearest; -1 of a rigid body.
   */
  int32_t vertices[2];
  /*
   Place, world [m].
   */
  double point[3];
  /*
   Unit vector from B to A, world.
   */
  double normal[3];
  /*
   Force on A, world; on B the opposite [N].
   */
  double force[3];
  /*
   Velocity of A along B, world [m/s].
   */
  double slip[3];
  /*
   Distance, negative inside [m].
   */
  double gap;
  /*
   Area that the point stands for; 0 between rigid bodies [m²].
   */
  double area;
  /*
   Coefficient of friction.
   */
  double friction;
  /*
   Friction gives all it can.
   */
  bool slips;
} ThenarContact;

/*
 Load that presses on a part of a hand.
 */
typedef struct ThenarLoad {
  /*
   Sum of normal forces [N].
   */
  double normal;
  /*
   Size of the summed tangential force [N].
   */
  double shear;
  /*
   Area in contact [m²].
   */
  double area;
  /*
   Mean on the skin [Pa].
   */
  double pressure;
  /*
   Force on the part, world [N].
   */
  double force[3];
  /*
   Centre of pressure, world [m].
   */
  double centre[3];
} ThenarLoad;

/*
 The report of a step.
 */
typedef struct ThenarReport {
  /*
   Contact points, near or touching.
   */
  uint32_t contacts;
  /*
   Contact points that bear load.
   */
  uint32_t contacts_active;
  /*
   Contact points left out for want of room; the deepest are kept.
   */
  uint32_t contacts_dropped;
  /*
   Parts in which the step was made: 1 unless contact did not carry it through.
   */
  uint32_t parts;
  /*
   Deepest penetration at the end of the step [m].
   */
  double penetration_max;
  /*
   Velocity error that contact leaves, as estimated [m/s].
   */
  double contact_residual;
  /*
   Contact missed the accuracy asked for.
   */
  bool contact_unconverged;
  /*
   A stand-in made the step, because the chosen solver could not.
   */
  bool fell_back;
  /*
   A number was not finite: what hangs together with it is where it was, at rest.
   */
  bool non_finite;
  /*
   Everything was taken back so, and no time passed.
   */
  bool taken_back;
} ThenarReport;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 Numbers of rigid bodies (hands' bones are some), deformable bodies (hands' flesh is some) and
 hands. Pass NULL for what is not wanted.

 # Safety
 `world` is NULL or a live handle; the others are NULL or have room for a number.
 */
enum ThenarStatus thenar_world_counts(const struct ThenarWorld *world,
                                      size_t *rigid_bodies,
                                      size_t *soft_bodies,
                                      size_t *hands);

/*
 The name of a rigid body; of a bone `hand/bone`. It stays until the world is freed. Contacts
 tell bodies by their place in the rigid bodies, then the deformable ones.

 # Safety
 `world` is NULL or a live handle; `name` has room for a pointer.
 */
enum ThenarStatus thenar_rigid_name(const struct ThenarWorld *world, size_t rigid, const char **name);

/*
 The name of a deformable body. It stays until the world is freed.

 # Safety
 `world` is NULL or a live handle; `name` has room for a pointer.
 */
enum ThenarStatus thenar_soft_name(const struct ThenarWorld *world, size_t soft, const char **name);

/*
 The name of a hand. It stays until the world is freed.

 # Safety
 `world` is NULL or a live handle; `name` has room for a pointer.
 */
enum ThenarStatus thenar_hand_name(const struct ThenarWorld *world, size_t hand, const char **name);

/*
 Pose of a rigid body's frame, whose origin is the centre of mass, in the world: position [m],
 quaternion x, y, z, w. `room` is 7.

 # Safety
 `world` is NULL or a live handle; `pose` is NULL or has room for `room` numbers.
 */
enum ThenarStatus thenar_rigid_pose(const struct ThenarWorld *world, size_t rigid, double *pose, size_t room);

/*
 Velocity of a rigid body's centre of mass [m/s], then its angular velocity [rad/s], world.
 `room` is 6.

 # Safety
 `world` is NULL or a live handle; `velocity` is NULL or has room for `room` numbers.
 */
enum ThenarStatus thenar_rigid_velocity(const struct ThenarWorld *world, size_t rigid, double *velocity, size_t room);

/*
 Nodes of a deformable body's tetrahedra, world, three numbers each [m]. `*count` gets how many
 numbers there are; `out`, unless it is NULL, gets them, and `room` says how many it can take.

 # Safety
 `world` is NULL or a live handle; `out` is NULL or has room for `room` numbers, `count` for one.
 */
enum ThenarStatus thenar_soft_nodes(const struct ThenarWorld *world,
                                    size_t soft,
                                    double *out,
                                    size_t room,
                                    size_t *count);

/*
 Vertices of a deformable body's surface that touches, world, three numbers each [m]. `out`,
 `room` and `count` are as of `thenar_soft_nodes`.

 # Safety
 As of `thenar_soft_nodes`.
 */
enum ThenarStatus thenar_soft_vertices(const struct ThenarWorld *world,
                                       size_t soft,
                                       double *out,
                                       size_t room,
                                       size_t *count);

/*
 Contact force on each vertex of a deformable body's surface in the last step, world, three
 numbers each [N]. `out`, `room` and `count` are as of `thenar_soft_nodes`.

 # Safety
 As of `thenar_soft_nodes`.
 */
enum ThenarStatus thenar_soft_vertex_forces(const struct ThenarWorld *world,
                                            size_t soft,
                                            double *out,
                                            size_t room,
                                            size_t *count);

/*
 Corners of the triangles of a deformable body's surface, three places in its vertices each,
 counter-clockwise from outside. They never change. `out`, `room` and `count` are as of
 `thenar_soft_nodes`.

 # Safety
 As of `thenar_soft_nodes`.
 */
enum ThenarStatus thenar_soft_triangles(const struct ThenarWorld *world,
                                        size_t soft,
                                        uint32_t *out,
                                        size_t room,
                                        size_t *count);

/*
 Words of the last refusal in this thread, UTF-8; empty when there was none. They stay until the
 next refusal in this thread: copy what is to be kept.
 */
const char *thenar_last_error(void);

/*
 Contact points of the last step. `*count` gets how many there are; `contacts`, unless it is
 NULL, gets them, and `room` says how many it can take. There are none after a reset or a state,
 until the next step.

 # Safety
 `world` is NULL or a live handle; `contacts` is NULL or has room for `room` contacts, `count`
 for a number.
 */
enum ThenarStatus thenar_world_contacts(const struct ThenarWorld *world,
                                        struct ThenarContact *contacts,
                                        size_t room,
                                        size_t *count);

/*
 Loads on palm, thumb, index, middle, ring and little finger of a hand in the last step. `room`
 is 6.

 # Safety
 `world` is NULL or a live handle; `loads` is NULL or has room for `room` loads.
 */
enum ThenarStatus thenar_hand_loads(const struct ThenarWorld *world,
                                    size_t hand,
                                    struct ThenarLoad *loads,
                                    size_t room);

/*
 Follows a wrist (7 numbers, as of `thenar_hand_wrist`) and twenty angles (as of
 `thenar_hand_angles`) from the next step on, as `thenar serve` follows a headset: smoothed,
 followed at limited speed, and lost when nothing comes for 0.1 s. `time`: when the pose was
 taken, by any clock [s]. Angles out of range are brought to its end.

 # Safety
 `world` is NULL or a live handle; `wrist` and `angles` are NULL or of as many numbers as their
 counts say.
 */
enum ThenarStatus thenar_hand_follow_angles(const struct ThenarWorld *world,
                                            size_t hand,
                                            double time,
                                            const double *wrist,
                                            size_t wrist_count,
                                            const double *angles,
                                            size_t angles_count);

/*
 Follows the 25 joints of WebXR Hand Input from the next step on, seven numbers each, as
 `thenar_hand_follow_angles` follows angles. `radii`: 25 of them [m], or NULL and 0.

 # Safety
 `world` is NULL or a live handle; `joints` and `radii` are NULL or of as many numbers as their
 counts say.
 */
enum ThenarStatus thenar_hand_follow_joints(const struct ThenarWorld *world,
                                            size_t hand,
                                            double time,
                                            const double *joints,
                                            size_t joints_count,
                                            const double *radii,
                                            size_t radii_count);

/*
 The hand is not tracked any more: it holds still until the next pose.

 # Safety
 `world` is NULL or a live handle.
 */
enum ThenarStatus thenar_hand_lose(const struct ThenarWorld *world, size_t hand);

/*
 The hand goes back to its scene's script.

 # Safety
 `world` is NULL or a live handle.
 */
enum ThenarStatus thenar_hand_follow_script(const struct ThenarWorld *world, size_t hand);

/*
 Pose of a hand's wrist in the world: position [m], quaternion x, y, z, w; -z towards the
 fingers, +y out of the back. `room` is 7.

 # Safety
 `world` is NULL or a live handle; `wrist` is NULL or has room for `room` numbers.
 */
enum ThenarStatus thenar_hand_wrist(const struct ThenarWorld *world, size_t hand, double *wrist, size_t room);

/*
 The twenty angles of a hand [rad]; NaN for a joint that it lacks. For each finger, thumb first:
 flexion and spread of its base joint, then flexion of its second and third. `room` is 20.

 # Safety
 `world` is NULL or a live handle; `angles` is NULL or has room for `room` numbers.
 */
enum ThenarStatus thenar_hand_angles(const struct ThenarWorld *world, size_t hand, double *angles, size_t room);

/*
 Poses of a hand's bones in the world, the palm first, seven numbers each: position [m],
 quaternion x, y, z, w; -z along the bone away from the wrist, +y out of the back. `*count` gets
 how many numbers there are; `poses`, unless it is NULL, gets them, and `room` says how many it
 can take.

 # Safety
 `world` is NULL or a live handle; `poses` is NULL or has room for `room` numbers, `count` for
 one.
 */
enum ThenarStatus thenar_hand_bone_poses(const struct ThenarWorld *world,
                                         size_t hand,
                                         double *poses,
                                         size_t room,
                                         size_t *count);

/*
 Opens a scene file. `overrides`: `overrides_count` texts such as `solver.cone="circular"`, as
 `--set` of the program; NULL and 0 for none. `*world` gets the handle, which `thenar_world_free`
 frees.

 # Safety
 `file` and each override end with a NUL; `world` has room for a pointer.
 */
enum ThenarStatus thenar_world_open(const char *file,
                                    const char *const *overrides,
                                    size_t overrides_count,
                                    struct ThenarWorld **world);

/*
 Opens a scene that comes along, by its name, such as `bread-grasp`. Else as `thenar_world_open`.

 # Safety
 `name` and each override end with a NUL; `world` has room for a pointer.
 */
enum ThenarStatus thenar_world_open_named(const char *name,
                                          const char *const *overrides,
                                          size_t overrides_count,
                                          struct ThenarWorld **world);

/*
 Opens a scene's text. `file` names it in messages; files that the scene names are looked for in
 its folder. Else as `thenar_world_open`.

 # Safety
 `text`, `file` and each override end with a NUL; `world` has room for a pointer.
 */
enum ThenarStatus thenar_world_open_text(const char *text,
                                         const char *file,
                                         const char *const *overrides,
                                         size_t overrides_count,
                                         struct ThenarWorld **world);

/*
 Frees a world; NULL is none. Names that were read of it go with it.

 # Safety
 `world` is NULL, or of a world that was opened, is not freed yet, and that no other thread uses.
 */
void thenar_world_free(struct ThenarWorld *world);

/*
 The `THENAR_ABI_VERSION` that the library was built with: compare it with the header's.
 */
uint32_t thenar_abi_version(void);

/*
 Makes `steps` steps. `report`, unless it is NULL, gets that of the last one.

 # Safety
 `world` is NULL or a live handle; `report` is NULL or has room for a report.
 */
enum ThenarStatus thenar_world_step(const struct ThenarWorld *world, uint64_t steps, struct ThenarReport *report);

/*
 Back to the start: time 0, bodies in their start states, scripts from the beginning. Settings
 stay, and so does who moves the hands.

 # Safety
 `world` is NULL or a live handle.
 */
enum ThenarStatus thenar_world_reset(const struct ThenarWorld *world);

/*
 Simulated time since the start [s], time step [s], steps since the start, and a hash of every
 bit of the state, as recordings have it. What is not wanted is NULL.

 # Safety
 `world` is NULL or a live handle; the others are NULL or have room for a number.
 */
enum ThenarStatus thenar_world_progress(const struct ThenarWorld *world,
                                        double *time,
                                        double *time_step,
                                        uint64_t *steps,
                                        uint64_t *state_hash);

/*
 Changes a setting from the next step on, such as `friction` to 0.4; SI units.

 # Safety
 `world` is NULL or a live handle; `key` is NULL or ends with a NUL.
 */
enum ThenarStatus thenar_world_set(const struct ThenarWorld *world, const char *key, double value);

/*
 Changes a setting that is a word, such as `solver` to `two-step`.

 # Safety
 `world` is NULL or a live handle; `key` and `word` are NULL or end with a NUL.
 */
enum ThenarStatus thenar_world_set_word(const struct ThenarWorld *world, const char *key, const char *word);

/*
 Everything that the next steps depend on, as bytes. `*count` gets how many there are; `state`,
 unless it is NULL, gets them, and `room` says how many it can take.

 # Safety
 `world` is NULL or a live handle; `state` is NULL or has room for `room` bytes, `count` for a
 number.
 */
enum ThenarStatus thenar_world_state(const struct ThenarWorld *world, uint8_t *state, size_t room, size_t *count);

/*
 Goes on from a state of this world, or of another of the same scene, with the same bits.

 # Safety
 `world` is NULL or a live handle; `state` is NULL or of `count` bytes.
 */
enum ThenarStatus thenar_world_set_state(const struct ThenarWorld *world, const uint8_t *state, size_t count);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus
