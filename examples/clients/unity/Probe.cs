// Tries ThenarClient.cs without Unity, for a test: leads the right hand up by 30 mm and tells what comes back.
//   mcs -r:System.dll Probe.cs ThenarClient.cs -out:probe.exe
//   mono probe.exe FIRST_BONE 8014, or, with --lan, mono probe.exe FIRST_BONE ADDRESS FINGERPRINT
using System;
using System.Globalization;
using System.Threading;
using Thenar;

static class Probe
{
    static int Main(string[] arguments)
    {
        CultureInfo.DefaultThreadCurrentCulture = CultureInfo.InvariantCulture;
        CultureInfo.CurrentCulture = CultureInfo.InvariantCulture;
        int bone = 7 * int.Parse(arguments[0]);
        var client = new ThenarClient();
        try
        {
            if (arguments.Length > 2) client.Connect(arguments[1], arguments[2]).Wait();
            else client.Connect("127.0.0.1", int.Parse(arguments[1])).Wait();
        }
        catch (AggregateException error)
        {
            Console.WriteLine("no connection: " + error.GetBaseException().Message);
            return 2;
        }
        var end = DateTime.UtcNow.AddSeconds(60);
        while (client.Model == null || client.Newest == null)
            if (!Wait(client, end)) return 1;
        Console.WriteLine("model " + client.Model.Length + " " + client.Model.Contains("\"bone_start\""));
        var begin = client.Newest;
        var wrist = new float[7];
        Array.Copy(begin.Rigids, bone, wrist, 0, 7);
        wrist[1] += 0.03f;
        uint sent = 0;
        Snapshot now = begin;
        // Until it is there: poses that are older than 0.1 s count as lost, so they are sent again and again.
        while (now.Rigids[bone + 1] - begin.Rigids[bone + 1] < 0.02f)
        {
            if (!Wait(client, end)) return 1;
            sent = client.Follow(1, now.Time + sent * 0.01, wrist, new float[20]).Result;
            now = client.Newest;
        }
        while (client.Newest.Pose < 2)
            if (!Wait(client, end)) return 1;
        now = client.Newest;
        Console.WriteLine("rose " + (now.Rigids[bone + 1] - begin.Rigids[bone + 1]));
        Console.WriteLine("pose " + (now.Pose <= sent && now.Pose > 0) + " " + (now.Number > begin.Number));
        Console.WriteLine("bodies " + now.Rigids.Length / 7 + " " + now.Loads.Length);
        // What makes no sense is refused by the server, in its words.
        client.Command("{\"type\":\"set\",\"key\":\"frction\",\"value\":1}").Wait();
        string text;
        while (true)
        {
            while (client.Texts.TryDequeue(out text))
                if (text.Contains("frction"))
                {
                    Console.WriteLine("refused " + text);
                    client.Dispose();
                    return 0;
                }
            if (!Wait(client, end)) return 1;
        }
    }

    static bool Wait(ThenarClient client, DateTime end)
    {
        Thread.Sleep(10);
        if (client.Ended != null || DateTime.UtcNow > end)
            Console.WriteLine("ended: " + (client.Ended ?? "too late"));
        return client.Ended == null && DateTime.UtcNow <= end;
    }
}
