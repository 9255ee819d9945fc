// The socket half of the Unity client: what `thenar serve` says and hears. It knows nothing of Unity, so that it can be
// built and tried without it. docs/protocol.md is the protocol; Thenar's frame is right-handed, +y up.
using System;
using System.Collections.Concurrent;
using System.IO;
using System.Net.Security;
using System.Net.Sockets;
using System.Net.WebSockets;
using System.Security.Cryptography;
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

        WebSocket socket;
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
            var plain = new ClientWebSocket();
            socket = plain;
            await plain.ConnectAsync(new Uri("ws://" + host + ":" + port + "/live"), stop.Token);
            _ = Task.Run(Listen);
        }

        /// <summary>Connects to an address that `thenar serve --lan` prints, https://192.168.1.5:8014/?token=…, if the
        /// server there has the fingerprint that is printed below it; another one hears nothing of the token.</summary>
        public async Task Connect(string address, string fingerprint)
        {
            var there = new Uri(address);
            var tcp = new TcpClient { NoDelay = true };
            await tcp.ConnectAsync(there.DnsSafeHost, there.Port);
            // By hand, as Mono's ClientWebSocket asks nobody about certificates.
            var secure = new SslStream(tcp.GetStream(), false, (sender, certificate, chain, errors) =>
            {
                using (var sha256 = SHA256.Create())
                    return BitConverter.ToString(sha256.ComputeHash(certificate.GetRawCertData())).Replace('-', ':')
                        == fingerprint.Trim().ToUpperInvariant();
            });
            await secure.AuthenticateAsClientAsync(there.DnsSafeHost);
            await Upgrade(secure, there);
            socket = WebSocket.CreateFromStream(secure, false, null, WebSocket.DefaultKeepAliveInterval);
            _ = Task.Run(Listen);
        }

        /// <summary>Asks for a WebSocket (RFC 6455, section 4.1).</summary>
        static async Task Upgrade(Stream stream, Uri there)
        {
            string key = Convert.ToBase64String(Guid.NewGuid().ToByteArray());
            byte[] asked = Encoding.ASCII.GetBytes("GET /live" + there.Query + " HTTP/1.1\r\nHost: " + there.Authority
                + "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: " + key
                + "\r\n\r\n");
            await stream.WriteAsync(asked, 0, asked.Length);
            string head = "";
            var one = new byte[1];
            while (!head.EndsWith("\r\n\r\n") && head.Length < 8192 && await stream.ReadAsync(one, 0, 1) == 1)
                head += (char)one[0];
            string accept;
            using (var sha1 = SHA1.Create())
                accept = Convert.ToBase64String(
                    sha1.ComputeHash(Encoding.ASCII.GetBytes(key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11")));
            if (!head.StartsWith("HTTP/1.1 101 ") || !head.Contains(accept))
                throw new IOException("no WebSocket at " + there.Authority + ": " + head.Split('\r')[0]);
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
            if (socket != null) socket.Dispose();
        }
    }
}
