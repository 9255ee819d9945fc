// Put this on an empty object: it shows the rigid bodies of `thenar serve` (a hand's bones are some), sends the pose of
// another object as the wrist, and tells the fingers' forces. Unity's frame is left-handed: z changes its sign.
using System;
using UnityEngine;

namespace Thenar
{
    public sealed class ThenarHand : MonoBehaviour
    {
        [Serializable] public sealed class Rigid { public string name; public string kind; public float radius; }
        [Serializable] public sealed class Hand { public string name; public string side; }
        [Serializable] public sealed class Model { public Rigid[] rigids; public Hand[] hands; }

        public string host = "127.0.0.1";
        public int port = 8014;
        [Tooltip("Instead of host and port: the address that `thenar serve --lan` prints")] public string address = "";
        [Tooltip("The fingerprint that it prints")] public string fingerprint = "";
        [Tooltip("0: left, 1: right")] public int hand = 1;
        [Tooltip("Where the wrist goes; nothing: the scene's script moves the hand")] public Transform wrist;
        [Tooltip("The twenty angles [rad]")] public float[] angles = new float[20];
        [Tooltip("Normal forces of palm, thumb, index, middle, ring, little [N]")] public float[] forces = new float[6];

        ThenarClient client;
        Transform[] bodies = new Transform[0];
        string shown;

        async void Start()
        {
            client = new ThenarClient();
            try { await (address == "" ? client.Connect(host, port) : client.Connect(address, fingerprint)); }
            catch (Exception error) { Debug.LogError("thenar: " + error.Message); }
        }

        void Update()
        {
            while (client.Texts.TryDequeue(out var text))
                if (text.Contains("\"type\":\"error\"")) Debug.LogWarning("thenar: " + text);
            if (client.Model != shown) Show(shown = client.Model);
            var now = client.Newest;
            if (now == null) return;
            for (int i = 0; i < bodies.Length && 7 * i + 6 < now.Rigids.Length; ++i)
                bodies[i].SetPositionAndRotation(Place(now.Rigids, 7 * i), Turn(now.Rigids, 7 * i + 3));
            for (int part = 0; part < 6 && now.Loads.Length >= 24; ++part) forces[part] = now.Loads[4 * part];
        }

        void FixedUpdate()
        {
            if (wrist == null || client.Newest == null || client.Ended != null) return;
            Vector3 p = wrist.position;
            Quaternion q = wrist.rotation;
            _ = client.Follow(hand, Time.fixedTimeAsDouble, new[] { p.x, p.y, -p.z, -q.x, -q.y, q.z, q.w }, angles);
        }

        void Show(string json)
        {
            foreach (var body in bodies) Destroy(body.gameObject);
            var model = JsonUtility.FromJson<Model>(json);
            bodies = Array.ConvertAll(model.rigids, rigid =>
            {
                var shape = rigid.kind == "bone" || rigid.kind == "sphere" ? PrimitiveType.Sphere : PrimitiveType.Cube;
                var body = GameObject.CreatePrimitive(shape).transform;
                body.name = rigid.name;
                body.parent = transform;
                body.localScale = Vector3.one * Mathf.Max(2 * rigid.radius, 0.01f);
                return body;
            });
        }

        static Vector3 Place(float[] n, int at) { return new Vector3(n[at], n[at + 1], -n[at + 2]); }

        static Quaternion Turn(float[] n, int at) { return new Quaternion(-n[at], -n[at + 1], n[at + 2], n[at + 3]); }

        void OnDestroy() { client?.Dispose(); }
    }
}
