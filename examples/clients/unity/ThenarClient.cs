// The socket half of the Unity client: what `thenar serve` says and hears. It knows nothing of Unity, so that it can be
// built and tried without it. docs/protocol.md is the protocol; Thenar's frame is right-handed, +y up.
using System;
using System.Collections.Concurrent;
using System.IO;
using System.Net.WebSockets;
using System.Text;
using System.Threading;
using System.Threading.Tasks;

namespace Thenar
{
    /// <summary>The world after a step.</summary>
    public sealed class Snapshot
    {
        public uint Epoch, Number, Pose;
        public double Time;
        /// <summary>Rigid bodies, 7 numbers each: position [m], quaternion x, y, z, w.</summary>
        public float[] Rigids;
        /// <summary>Nodes of the deformable bodies, 3 numbers each [m].</summary>
        public float[] Nodes;
        /// <summary>For each hand, for palm, thumb, index, middle, ring, little: normal [N], shear [N], area [m2],
        /// pressure [Pa].</summary>
        public float[] Loads;
    }

    /// <summary>A connection to `thenar serve`. One thread of its own listens; everybody else takes what is newest.</summary>
    public sealed class ThenarClient : IDisposable
    {
        public const byte Version = 3;
        const byte KindModel = 1, KindSnapshot = 2, KindAngles = 17, KindLost = 18;

        readonly ClientWebSocket socket = new ClientWebSocket();
        readonly CancellationTokenSource stop = new CancellationTokenSource();
        readonly uint[] poses = new uint[2];
        // A WebSocket takes one message at a time.
        readonly SemaphoreSlim sending = new SemaphoreSlim(1, 1);

        /// <summary>The newest description of the bodies, JSON; null before the first.</summary>
        public volatile string Model;
        /// <summary>The newest snapshot; null before the first.</summary>
        public volatile Snapshot Newest;
        /// <summary>Why the connection has ended; null while it lasts.</summary>
        public volatile string Ended;
        /// <summary>Texts of the server: welcome, status, errors.</summary>
        public readonly ConcurrentQueue<string> Texts = new ConcurrentQueue<string>();

        /// <summary>Connects and begins to listen.</summary>
        public async Task Connect(string host, int port)
        {
            await socket.ConnectAsync(new Uri("ws://" + host + ":" + port + "/live"), stop.Token);
            _ = Task.Run(Listen);
        }

        async Task Listen()
        {
            var part = new ArraySegment<byte>(new byte[65536]);
            try
            {
                while (!stop.IsCancellationRequested)
                {
                    var whole = new MemoryStream();
                    WebSocketReceiveResult got;
                    do
                    {
                        got = await socket.ReceiveAsync(part, stop.Token);
                        whole.Write(part.Array, 0, got.Count);
                    } while (!got.EndOfMessage);
                    if (got.MessageType == WebSocketMessageType.Close)
                        throw new IOException("thenar has closed: " + got.CloseStatusDescription);
                    Take(got.MessageType, whole.ToArray());
                }
            }
            catch (Exception error)
            {
                Ended = error.Message;
            }
        }

        void Take(WebSocketMessageType type, byte[] data)
        {
            if (type == WebSocketMessageType.Text)
            {
                Texts.Enqueue(Encoding.UTF8.GetString(data));
                return;
            }
            if (data[1] != Version)
                throw new IOException("a message of protocol " + data[1] + ", expected " + Version);
            if (data[0] == KindModel)
                Model = Encoding.UTF8.GetString(data, 16, BitConverter.ToInt32(data, 8));
            else if (data[0] == KindSnapshot)
                Newest = Read(data);
        }

        /// <summary>Reads a snapshot, table 2 of the protocol. Both sides are little-endian.</summary>
        public static Snapshot Read(byte[] data)
        {
            int rigids = BitConverter.ToInt32(data, 64), nodes = BitConverter.ToInt32(data, 68);
            int targets = BitConverter.ToInt32(data, 72), contacts = BitConverter.ToInt32(data, 76);
            int hands = BitConverter.ToInt32(data, 80), at = 88;
            Func<int, float[]> floats = count =>
            {
                var read = new float[count];
                Buffer.BlockCopy(data, at, read, 0, 4 * count);
                at += 4 * count;
                return read;
            };
            var snapshot = new Snapshot
            {
                Epoch = BitConverter.ToUInt32(data, 4),
                Number = BitConverter.ToUInt32(data, 8),
                Time = BitConverter.ToDouble(data, 16),
                Pose = BitConverter.ToUInt32(data, 56),
                Rigids = floats(7 * rigids),
                Nodes = floats(3 * nodes),
            };
            floats(7 * targets);
            snapshot.Loads = floats(24 * hands);
            if (data.Length != at + 48 * contacts)
                throw new IOException("a snapshot of " + data.Length + " bytes, expected " + (at + 48 * contacts));
            return snapshot;
        }

        /// <summary>Sends where the left (0) or right (1) wrist goes (7 numbers), and the twenty angles [rad]; the
        /// number comes back in a snapshot.</summary>
        public async Task<uint> Follow(int hand, double clock, float[] wrist, float[] angles)
        {
            if (wrist.Length != 7 || angles.Length != 20)
                throw new ArgumentException("expected 7 numbers of the wrist and 20 angles");
            var numbers = new byte[4 * 27];
            Buffer.BlockCopy(wrist, 0, numbers, 0, 28);
            Buffer.BlockCopy(angles, 0, numbers, 28, 80);
            await Pose(KindAngles, hand, clock, numbers);
            return poses[hand];
        }

        /// <summary>The hand is not tracked any more.</summary>
        public Task Lose(int hand, double clock)
        {
            return Pose(KindLost, hand, clock, new byte[0]);
        }

        Task Pose(byte kind, int hand, double clock, byte[] body)
        {
            var message = new MemoryStream();
            var write = new BinaryWriter(message);
            write.Write(new byte[] { kind, Version, (byte)hand, 0 });
            write.Write(++poses[hand]);
            write.Write(clock);
            write.Write(body);
            return Send(WebSocketMessageType.Binary, message.ToArray());
        }

        /// <summary>Sends a command, such as {"type":"run","paused":true}.</summary>
        public Task Command(string json)
        {
            return Send(WebSocketMessageType.Text, Encoding.UTF8.GetBytes(json));
        }

        async Task Send(WebSocketMessageType type, byte[] data)
        {
            await sending.WaitAsync(stop.Token);
            try
            {
                await socket.SendAsync(new ArraySegment<byte>(data), type, true, stop.Token);
            }
            finally
            {
                sending.Release();
            }
        }

        public void Dispose()
        {
            stop.Cancel();
            socket.Dispose();
        }
    }
}
